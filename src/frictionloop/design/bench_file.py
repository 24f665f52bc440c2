"""A System from a file or a preset with changes: what was given, what is in doubt, and what it was designed for."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping
from dataclasses import asdict, fields
from typing import TYPE_CHECKING, Any, NamedTuple

from frictionloop.design.requirements import Requirements
from frictionloop.findings import Finding
from frictionloop.findings.result import plain
from frictionloop.parameters import System, preset, read_toml, write_toml
from frictionloop.parameters.doubtful_values import differing, named_by, unusual
from frictionloop.parameters.frozen_blocks import flat
from frictionloop.parameters.toml_reader import DESIGNED, read_tree, start_of
from frictionloop.sensing.finger_tracking import check_follows

if TYPE_CHECKING:
    from frictionloop.design.controller_check import Check


DECIDES = ("friction", "plate", "sensor", "controller", "finger")
"""Blocks that decide what gains are right."""


class DesignedTable(NamedTuple):
    """What a file says of its controller."""

    requirements: Requirements
    given: frozenset[str]
    """Dotted names of values that somebody gave."""
    values: dict[str, Any]
    """The bench and its controller, by dotted name."""
    findings: tuple[Finding, ...]


def write_controller(found: Check, path: str | os.PathLike[str], given: Collection[str] = ()) -> None:
    """Write the system of a check or a design, with what it holds for."""
    told = [each for each in found.findings if each.code != "ASSUMED"]
    table = {
        "holds": found.holds,
        "for": _written(asdict(found.requirements)),
        "people": _written(found.drawn),
        "values": _deciding(found.system),
        "given": sorted(given),
        "findings": [_written(each.to_dict()) for each in told],
    }
    write_toml(found.system, path, designed=table, given=given)


def _written(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return what TOML has words for."""
    return {name: value for name, value in plain(values).items() if value is not None}


def read_designed(path: str | os.PathLike[str]) -> DesignedTable | None:
    """Return what the table [designed] of a file says; None without one."""
    table = read_tree(path).get(DESIGNED)
    if not isinstance(table, dict):
        return None
    known = {each.name for each in fields(Requirements)}
    asked = {name: _tuples(value) for name, value in table.get("for", {}).items() if name in known}
    findings = tuple(Finding.from_dict(each) for each in table.get("findings", ()))
    return DesignedTable(Requirements(**asked), frozenset(table.get("given", ())), table.get("values", {}), findings)


def changed_since(system: System, table: DesignedTable) -> tuple[Finding, ...]:
    """Return that values of a system are not those that its file was designed with."""
    now = _deciding(system)
    changed = {name: value for name, value in table.values.items() if now.get(name) != value}
    return (Finding("SPEC-CHANGED", value=changed),) if changed else ()


def _deciding(system: System) -> dict[str, Any]:
    """Return what decides which gains are right, by dotted name."""
    return _written(flat(flat({block: getattr(system, block).model_dump() for block in DECIDES})))


def _tuples(value: Any) -> Any:
    return tuple(_tuples(each) for each in value) if isinstance(value, list) else value


class Described(NamedTuple):
    """A System and how it was described."""

    system: System
    stated: frozenset[str]
    """Dotted names of values that somebody gave."""
    findings: tuple[Finding, ...]


def described(
    file: str | os.PathLike[str] | None = None,
    preset_name: str = "bench",
    overrides: Mapping[str, Any] | None = None,
    law: str | None = None,
) -> Described:
    """Return the System of a file, or a preset without one, with overrides, and what of it is in doubt.

    Parameters
    ----------
    file
        TOML file, beside its preset or whole.
    preset_name
        Preset without a file: paper, feasible or bench.
    overrides
        Values by dotted name; ``friction.coefficient`` is friction over load, in place of ``friction.nominal_n``.
    law
        Law that a controller is to be designed for, which sets some of what it believes.

    Raises
    ------
    FrictionloopError
        As `read_toml` and ``System.evolve``, or a finger that the controller cannot follow.
    """
    base = preset(preset_name) if file is None else read_toml(file)
    own = base.resolved(overrides or {})
    system = base.evolve(own)
    check_follows(system.motion, system.touch)  # a run would refuse it, after a design of some minutes
    start, changes = (None, {}) if file is None else start_of(file)
    changes = start.resolved(flat(changes)) if start else flat(changes)
    table = None if file is None else read_designed(file)
    found = [*_kinds(start, base, changes)] if start is not None else []
    found += [*_kinds(base, system, own), *unusual(system)]
    found += differing(system, named_by(changes, own), law)
    found += changed_since(system, table) if table is not None and law is None else ()
    stated = {*(changes if start else ()), *own, *(table.given if table else ())}
    return Described(system, frozenset(stated), tuple(found))


def _kinds(base: System, system: System, overrides: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield each block of a new kind that has its own defaults where the old kind had other values."""
    for name in type(base).model_fields:
        old, new = getattr(base, name), getattr(system, name)
        if f"{name}.kind" in overrides and old.kind != new.kind:
            shared = type(old).model_fields.keys() & type(new).model_fields.keys() - {"kind"}
            said = {path.split(".")[1] for path in overrides if path.startswith(f"{name}.")}
            left = [each for each in type(new).model_fields if each in shared - said]
            values = {f"{name}.{each}": getattr(old, each) for each in left if getattr(old, each) != getattr(new, each)}
            if values:
                yield Finding("KIND-DEFAULTS", value=f"{name}.kind = {new.kind}", remedy=values, more={"old": old.kind})
