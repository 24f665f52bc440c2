"""What a person is told of fingers that a sweep puts in the place of the system's own: which values they replace."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from frictionloop.quantities import unit_of

if TYPE_CHECKING:
    from frictionloop.parameters import System
    from frictionloop.physics.fingers import Fingers

NUMBERED = ("motion.load_n", "friction.nominal_n", "friction.susceptibility_per_um2")
"""Values that a bench is described by, told with their numbers; of the others the names."""
NO_VALUE = ("motion.person",)
"""What numbers a finger, and describes nothing."""


def replaced(system: System, people: Fingers) -> dict[str, Any]:
    """Return the system's own values that each finger replaces, by their dotted names."""
    return {path: _of(system, path) for path in people[0] if path not in NO_VALUE}


def replaced_said(system: System, people: Fingers) -> str:
    """Return in words what fingers have in place of what a system has."""
    own = replaced(system, people)
    told = [_range(path, own.pop(path), [each[path] for each in people]) for path in NUMBERED if path in own]
    blocks: dict[str, list[str]] = {}
    for path in own:
        block, _, name = path.partition(".")
        blocks.setdefault(block, []).append(name)
    names = "; ".join(f"{block}: {', '.join(named)}" for block, named in blocks.items())
    return f"Each finger replaces {', '.join(told)}. Of its own are also {names}."


def unlike(system: System, people: Fingers) -> str:
    """Return that the system's finger is none like these, where a value that it is described by lies outside theirs."""
    said = []
    for path in (each for each in NUMBERED if each in people[0]):
        values, own = [each[path] for each in people], _of(system, path)
        if not min(values) <= own <= max(values):
            unit = f" {unit_of(path)}" if unit_of(path) else ""
            said.append(f"{path} = {own:.3g}{unit} is outside theirs, {min(values):.3g} to {max(values):.3g}")
    return f"None of these fingers is like that of the file, which they replace: {'; '.join(said)}." if said else ""


def _range(path: str, own: Any, values: Sequence[float]) -> str:
    unit = f" {unit_of(path)}" if unit_of(path) else ""
    return f"{path} {own:.3g}{unit} by its own ({min(values):.3g} to {max(values):.3g})"


def _of(system: System, path: str) -> Any:
    block, name = path.split(".")
    return getattr(getattr(system, block), name)
