"""Values that are allowed and asked about: such as no bench has, and of a controller that knows another bench."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from operator import attrgetter
from typing import Any

from pydantic import BaseModel

from frictionloop.cli import screen
from frictionloop.parameters import System, bench
from frictionloop.quantities import unit_of

USUAL = {
    "nominal_n": (0.01, 20.0),
    "susceptibility_per_um2": (1e-3, 50.0),
    "max_amplitude_um": (0.05, 50.0),
    "cutoff_hz": (1.0, 1e5),
    "frequency_hz": (0.01, 2e5),
    "resonance_hz": (5.0, 1e4),
    "moving_mass_kg": (1e-3, 10.0),
    "noise_rms_n": (1e-8, 0.5),
    "noise_density_n_rthz": (1e-9, 3e-4),
    "range_n": (0.05, 100.0),
    "rate_hz": (100.0, 2e5),
    "delay_s": (1e-7, 0.05),
    "offset_n": (1e-3, 20.0),
    "amplitude_n": (1e-4, 20.0),
    "load_n": (0.01, 20.0),
    "speed_mm_s": (0.5, 1000.0),
    "stroke_mm": (2.0, 1000.0),
    "tremor_um": (0.5, 500.0),
    "tremor_n": (1e-4, 1.0),
    "stiffness_n_m": (20.0, 1e5),
    "mass_kg": (1e-6, 0.01),
}
"""Ranges by a parameter's name, the ends a decade or so beyond what is published of fingers and displays (chosen)."""

USUAL_OF = {
    "plate.frequency_hz": (5e3, 2e5),
    "plate.q": (2.0, 1e5),
    "moving.mass_kg": (1e-3, 10.0),
    "springs.width_mm": (0.5, 500.0),
    "springs.thickness_mm": (0.02, 20.0),
    "electrodes.area_mm2": (1.0, 1e5),
    "electrodes.gap_um": (5.0, 5000.0),
    "excitation.frequency_hz": (1e3, 1e7),
    "geometry.length_mm": (5.0, 2000.0),
    "geometry.width_mm": (5.0, 2000.0),
    "geometry.thickness_mm": (0.1, 20.0),
    "drive.resonance_hz": (5e3, 2e5),
    "disturbance.offset_n": (1e-12, 20.0),  # the mean of what its mean was taken from
    "disturbance.rate_hz": (1.0, 2e6),
    "setpoint.rate_hz": (1.0, 2e6),
}
"""Ranges of those whose name alone does not say: ultrasound, a plate that resonates, and what one builds (chosen)."""
PREFIXES = (1e-6, 1e-3, 1e3, 1e6)

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


def differing(system: System, named: Collection[str], designed: str | None = None) -> Iterator[str]:
    """Yield a line for each value that the plant and the controller's model have differently and the law uses.

    Only one of the two was named (`named_by`): who names both means it so. A law that is to be ``designed`` uses what
    it will.
    """
    plate, thought = system.plate.max_amplitude_um, system.controller.model.max_amplitude_um
    told = {"plate.max_amplitude_um", "controller.model.max_amplitude_um"}.intersection(named)
    asked = any(_of_value("plate.max_amplitude_um", plate))  # whether it is meant comes first
    if thought != plate and not asked and told == {"plate.max_amplitude_um"}:
        more = "" if thought > plate else " and asks for no more"
        yield (
            f"plate.max_amplitude_um is {plate:g} um, and the controller believes {thought:g} um{more}; if it is to "
            f"know: controller.model.max_amplitude_um = {plate:g}"
        )
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
            unit = f" {unit_of(path)}" if unit_of(path) else ""
            yield (
                f"{path} is {true:g}{unit}, and the controller believes {believed:g}{unit}; if it is to know: "
                f"{model} = {true:g}"
            )


def _used(system: System, designed: str | None) -> Collection[str]:
    controller: Any = system.controller
    if designed != "pi" and (designed or controller.kind == OBSERVING or getattr(controller, "feedforward", False)):
        return BELIEVED
    return ["plate_hz"] if designed is None and getattr(controller, "overdrive", False) else []


def ask(described: System | BaseModel) -> None:
    """Note the questions about a system or a design, for stderr."""
    for line in questions(described):
        screen.note(line)


def ask_of_ceiling(system: System) -> None:
    """Note that a simulation leaves out the ceiling of a board, where that is below what the plate gives."""
    ceiling_um, largest_um = system.board.ceiling_um, system.plate.max_amplitude_um
    if ceiling_um is not None and ceiling_um < largest_um:
        screen.note(
            f"board.ceiling_um = {ceiling_um:g} um holds on a board alone: what is simulated here goes up to "
            f"{largest_um:g} um (plate.max_amplitude_um)"
        )


def ask_of_axes(axes: Mapping[str, Sequence[Any]]) -> None:
    """Note a question for each parameter that is swept over values that are far from the usual, about the farthest."""
    for path, values in axes.items():
        numbers = sorted(float(each) for each in values if isinstance(each, (int, float)))
        said = [line for end in (numbers[:1], numbers[-1:]) for each in end for line in _of_value(path, each)]
        for line in said[:1]:
            screen.note(line)


def questions(described: BaseModel) -> Iterator[str]:
    """Yield a line for each value that is far from what such benches have; 0 is none of something, and no question."""
    for name, block in described:
        yield from _of_block(name, block)


def _of_block(path: str, block: BaseModel) -> Iterator[str]:
    for key, value in block:
        name = f"{path}.{key}"
        yield from _of_block(name, value) if isinstance(value, BaseModel) else _of_value(name, value)


def _of_value(path: str, value: Any) -> Iterator[str]:
    usual = USUAL_OF.get(path) or USUAL.get(path.rpartition(".")[2])
    if usual is not None and _is_far(value, *usual):
        yield _asked(path, value, usual)


def _asked(name: str, value: float, usual: tuple[float, float]) -> str:
    unit, (low, high) = unit_of(name), usual
    meant = _meant(abs(value), low, high)
    hint = "" if meant is None else f"; did you mean {meant:g} {unit}?"
    return f"{name} = {value:g} {unit}: is the unit right? Usual are {low:g} to {high:g} {unit}{hint}"


def _meant(value: float, low: float, high: float) -> float | None:
    """Return the value in the range that a wrong prefix, as milli or kilo, is nearest to; None if there is none."""
    found = [value * factor for factor in PREFIXES if low <= value * factor <= high]
    middle = math.log(low * high) / 2.0
    return min(found, key=lambda each: abs(math.log(each) - middle), default=None)


def suggested(error: str) -> str:
    """Return a refusal with the value that was meant, where a wrong prefix of its unit explains it."""
    found = re.search(r"([a-z_]+)\.([a-z_0-9]+) = (-?[0-9.e+-]+) \w+: must be", error)
    usual = USUAL.get(found[2]) if found else None
    if found is None or usual is None:
        return error
    meant = _meant(abs(float(found[3])), *usual)
    return error if meant is None else f"{error}; did you mean {meant:g} {unit_of(found[2])}?"


def _is_far(value: Any, low: float, high: float) -> bool:
    return isinstance(value, float) and value != 0.0 and not low <= abs(value) <= high
