"""The table [designed] of a file: what was asked, found and given by a person. No part of the System's identity."""

from __future__ import annotations

import os
from collections.abc import Collection
from dataclasses import fields
from typing import TYPE_CHECKING, Any, NamedTuple

from frictionloop.design.requirements import Requirements
from frictionloop.findings import Finding
from frictionloop.findings.result import plain
from frictionloop.parameters import System, write_toml
from frictionloop.parameters.files import DESIGNED, read_tree
from frictionloop.parameters.summary import own_values

if TYPE_CHECKING:
    from frictionloop.design.controller_check import Check


class DesignedTable(NamedTuple):
    """What a file says of its controller."""

    requirements: Requirements
    given: frozenset[str]
    """Dotted names of values that somebody gave."""
    gains: dict[str, Any]


def write_controller(found: Check, path: str | os.PathLike[str], given: Collection[str] = ()) -> None:
    """Write the system of a check or a design, with what it holds for."""
    told = [each for each in found.findings if each.code != "ASSUMED"]
    table = {
        "holds": found.holds,
        "for": plain(found.requirements.given),
        "gains": plain(own_values(found.system)),
        "given": sorted(given),
        "findings": [f"{each.severity} {each.code}: {each}" for each in told],
    }
    write_toml(found.system, path, designed=table, given=given)


def read_designed(path: str | os.PathLike[str]) -> DesignedTable | None:
    """Return what the table [designed] of a file says; None without one."""
    table = read_tree(path).get(DESIGNED)
    if not isinstance(table, dict):
        return None
    known = {each.name for each in fields(Requirements)}
    asked = {name: _tuples(value) for name, value in table.get("for", {}).items() if name in known}
    return DesignedTable(Requirements(**asked), frozenset(table.get("given", ())), dict(table.get("gains", {})))


def changed_since(system: System, table: DesignedTable) -> tuple[Finding, ...]:
    """Return that the gains of a system are not those that its file was designed with."""
    own = plain(own_values(system))
    then = {name: value for name, value in table.gains.items() if own.get(name) != value}
    return (
        (Finding("SPEC-CHANGED", value={f"controller.{name}": value for name, value in then.items()}),) if then else ()
    )


def _tuples(value: Any) -> Any:
    return tuple(_tuples(each) for each in value) if isinstance(value, list) else value
