"""Values that are allowed and in doubt: such as no bench has, and of a controller that believes in another bench."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from operator import attrgetter
from typing import Any

from pydantic import BaseModel

from frictionloop.findings import Finding
from frictionloop.parameters.presets import bench
from frictionloop.parameters.refusals import USUAL, USUAL_OF, likely
from frictionloop.parameters.system import System
from frictionloop.quantities import unit_of

BELIEVED = {
    "plate_hz": ("plate.cutoff_hz", ("plate.cutoff_hz", "plate.frequency_hz", "plate.q")),
    "resonance_hz": ("sensor.resonance_hz", ("sensor.resonance_hz",)),
    "resonance_q": ("sensor.q", ("sensor.q",)),
    "sensor_hz": ("sensor.cutoff_hz", ("sensor.cutoff_hz",)),
}
"""Of ``controller.model``: the plant's value, and the parameters that decide it."""
AMPLITUDES = ("controller.model.max_amplitude_um", ("plate.max_amplitude_um",))
OBSERVING = "limit_observer"
"""The kind of law that computes with all of these; others do with feed-forward, and with ``plate_hz`` for overdrive."""
SET_BY_DESIGN = {"notch_pi": {"resonance_hz", "resonance_q"}, OBSERVING: {"resonance_hz", "resonance_q", "sensor_hz"}}
"""What a design takes from the sensor and saves."""


def named_by(file: Mapping[str, Any], flags: Collection[str]) -> set[str]:
    """Return what a file and flags name, without what a file has a controller believe that nobody may have meant.

    That is a value equal to that of `bench()`, as a file written whole has it, and what it believes of a plant that
    flags change.
    """
    pairs = [*((f"controller.model.{name}", deciding) for name, (_, deciding) in BELIEVED.items()), AMPLITUDES]
    old = {model for model, deciding in pairs if model not in flags and any(each in flags for each in deciding)}
    old |= {model for model, _ in pairs if model not in flags and file.get(model) == attrgetter(model)(bench())}
    return {*flags, *(each for each in file if each not in old)}


def differing(system: System, named: Collection[str], designed: str | None = None) -> Iterator[Finding]:
    """Yield each value that the plant and the controller's model have differently and the law uses.

    Only one of the two was named (`named_by`): who names both means it so. A law that is to be ``designed`` uses what
    it will.
    """
    path, (own,) = AMPLITUDES
    plate, thought = system.plate.max_amplitude_um, system.controller.model.max_amplitude_um
    asked = any(_of_value(own, plate))  # whether it is meant comes first
    if thought != plate and not asked and {own, path}.intersection(named) == {own}:
        yield _believed(own, path, plate, thought)
    for name in _used(system, designed):
        if name in SET_BY_DESIGN.get(designed or "", ()):
            continue
        path, deciding = BELIEVED[name]
        model = f"controller.model.{name}"
        if (model in named) == any(each in named for each in deciding):
            continue
        try:
            true = float(attrgetter(path)(system))
        except AttributeError:  # a sensor without a resonance
            continue
        believed = getattr(system.controller.model, name)
        if believed != true:
            yield _believed(path, model, true, believed)


def _believed(path: str, model: str, true: float, believed: float) -> Finding:
    return Finding(
        "BELIEF-DIFFERS", value=true, unit=unit_of(path), limit=believed, remedy={model: true}, more={"path": path}
    )


def _used(system: System, designed: str | None) -> Collection[str]:
    controller: Any = system.controller
    if designed != "pi" and (designed or controller.kind == OBSERVING or getattr(controller, "feedforward", False)):
        return BELIEVED
    return ["plate_hz"] if designed is None and getattr(controller, "overdrive", False) else []


def of_ceiling(system: System) -> Iterator[Finding]:
    """Yield that a simulation leaves out the ceiling of a board, where that is below what the plate gives."""
    ceiling_um, largest_um = system.board.ceiling_um, system.plate.max_amplitude_um
    if ceiling_um is not None and ceiling_um < largest_um:
        yield Finding("BOARD-CEILING", value=ceiling_um, unit="um", limit=largest_um)


def of_axes(axes: Mapping[str, Sequence[Any]]) -> Iterator[Finding]:
    """Yield the farthest value of each parameter that is swept far from the usual."""
    for path, values in axes.items():
        numbers = sorted(float(each) for each in values if isinstance(each, (int, float)))
        yield from [found for end in (numbers[:1], numbers[-1:]) for each in end for found in _of_value(path, each)][:1]


def unusual(described: BaseModel) -> Iterator[Finding]:
    """Yield each value that is far from what such benches have; 0 is none of something, and no question."""
    for name, block in described:
        yield from _of_block(name, block)


def _of_block(path: str, block: BaseModel) -> Iterator[Finding]:
    for key, value in block:
        name = f"{path}.{key}"
        yield from _of_block(name, value) if isinstance(value, BaseModel) else _of_value(name, value)


def _of_value(path: str, value: Any) -> Iterator[Finding]:
    usual = USUAL_OF.get(path) or USUAL.get(path.rpartition(".")[2])
    if usual is None or not isinstance(value, float) or value == 0.0 or usual[0] <= abs(value) <= usual[1]:
        return
    meant = likely(abs(value), *usual)
    more = {"path": path, "low": usual[0], "high": usual[1]}
    yield Finding(
        "UNIT-DOUBT", value=value, unit=unit_of(path), remedy={} if meant is None else {path: meant}, more=more
    )
