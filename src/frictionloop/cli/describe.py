"""A system in words: one row per block under the names that flags use, and what follows from its numbers."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

from frictionloop.cli.derived import notes_of
from frictionloop.parameters import Board, System

Row = tuple[str, ...]


def system_rows(system: System) -> list[Row]:
    """Return (block, its kind and values) for each block, nested blocks after the one that holds them."""
    rows: list[Row] = []
    notes = notes_of(system)
    for name, block in system:
        # Where the finger is and how hard it presses is neither known nor used without a motion, and the wiring of a
        # board by no simulation: worth a row only where somebody has set it.
        unused = (name == "touch" and system.motion.kind == "sliding") or (name == "board" and block == Board())
        if not unused:
            rows += _block_rows(name, block, notes)
    return rows


def _block_rows(name: str, block: BaseModel, notes: dict[str, str]) -> list[Row]:
    kind, values, inner = "", [], []
    for key in block.model_dump():  # in the order of files: a law's own values before what all controllers have
        value = getattr(block, key)
        if key == "kind":
            kind = str(value)
        elif isinstance(value, BaseModel):
            inner += _block_rows(f"{name}.{key}", value, notes)
        elif value is not None:
            values.append(f"{key}={short(value)}")
    said = ": ".join(part for part in (kind, ", ".join(values)) if part)
    own: list[Row] = [(name, said)] if said else []
    return [*own, *([("", f"-> {notes[name]}")] if name in notes else []), *inner]


def short(value: Any) -> str:
    """Return a value with at most six digits, a long list by its first values."""
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (list, tuple)):
        shown = ", ".join(map(short, value[:6]))
        return f"[{shown}]" if len(value) <= 6 else f"[{shown}, ... {len(value)} values]"
    return str(value)
