"""A system as rows of a table, for verbs whose answer is no result yet."""

from __future__ import annotations

from typing import Any

from frictionloop.parameters import System
from frictionloop.parameters.summary import listed, short, summary

__all__ = ["Row", "finger_values", "short", "system_rows"]
Row = tuple[str, ...]


def system_rows(system: System) -> list[Row]:
    """Return (block, its kind and values) for each block."""
    rows: list[Row] = []
    for name, each in summary(system).items():
        rows.append((name, ": ".join(filter(None, (each.kind, listed(each.values))))))
        rows += [("", f"-> {listed(each.derived)}")] if each.derived else []
    return rows


def finger_values(system: System) -> dict[str, Any]:
    """Return the values of friction and motion under their dotted names, as `capable` reads them."""
    blocks = {"friction": system.friction, "motion": system.motion}
    return {f"{name}.{key}": value for name, block in blocks.items() for key, value in block}
