"""Does a system fit the board as its firmware is written? What would be wrong on it, before anything is built."""

from __future__ import annotations

import math

from frictionloop.firmware.effect_tables import STORE
from frictionloop.parameters import ResonantPlate, Steps, Strokes, System
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.schema import schema

BUS_HZ = 36e6
"""Clock of the carrier's timer."""
USUAL_TICKS = 783
"""Period of the carrier in an image for no certain plate: 46 kHz, as the paper's."""
MOST_TICKS = 32766
"""Longest period whose product with a duty the board has room for."""
COUNTS, ROOM = 2**15 - 1, 1.1
"""Largest reading of a converter, and what a stroke leaves of it free (chosen)."""
SCALE = "board.position_m_per_count"
"""Of the position sensor; negative where it counts the other way."""
LEAST_LEFT = 0.9
"""Share of the plate's amplitude at the carrier below which it is told (chosen)."""


def period_ticks(system: System) -> int:
    """Return the period of the carrier in the image of a system, in ticks of its timer: the nearest to the plate.

    Raises
    ------
    FrictionloopError
        For a plate whose period the timer cannot have.
    """
    plate = system.plate
    if not isinstance(plate, ResonantPlate):
        return USUAL_TICKS
    ticks = round(BUS_HZ / plate.frequency_hz)
    if not 2 <= ticks <= MOST_TICKS:
        raise FrictionloopError(
            f"plate.frequency_hz = {plate.frequency_hz:g} Hz: the board's carrier must be from "
            f"{BUS_HZ / MOST_TICKS:.0f} Hz to {BUS_HZ / 2:.3g} Hz"
        )
    return ticks


def carrier_hz(system: System) -> float:
    """Return the frequency of the carrier in the image of a system."""
    return BUS_HZ / period_ticks(system)


def amplitude_left(plate: ResonantPlate, at_hz: float) -> float:
    """Return the amplitude at a carrier over that at the plate's resonance, 1 / sqrt(1 + ((f - f0) / fc)^2).

    fc = f0 / (2 Q) is the corner of the envelope (docs/plate).
    """
    return 1.0 / math.hypot(1.0, (at_hz - plate.frequency_hz) / plate.cutoff_hz)


def carrier_said(system: System) -> str:
    """Return the carrier of a system's image in words, and what the plate gives there; empty without a resonance."""
    plate = system.plate
    if not isinstance(plate, ResonantPlate):
        return ""
    ticks, at_hz = period_ticks(system), carrier_hz(system)
    left = amplitude_left(plate, at_hz)
    gives = f"where the plate gives {100 * left:.3g} % of its amplitude at resonance"
    return f"{at_hz:.0f} Hz, {BUS_HZ / 1e6:g} MHz / {ticks}, {gives}"


def misfits(system: System) -> list[str]:
    """Return what of a system the firmware does not do, a line each; nothing where all fits."""
    return [*misfits_of_gains(system), *_beyond_position(system), *_steps(system)]


def misfits_of_gains(system: System) -> list[str]:
    """Return those that take other gains, or another amplitude, a line each."""
    said, plate, rate_hz = [], system.plate, _tick_hz()
    if system.controller.rate_hz != rate_hz:
        said.append(
            f"controller.rate_hz = {system.controller.rate_hz:g} Hz: the project's firmware runs at {rate_hz:g} Hz "
            f"only, and these gains are not for it; for its board design with --controller.rate_hz {rate_hz:g}"
        )
    if isinstance(plate, ResonantPlate):
        said += _off_the_carrier(system, plate)
    return said


def _tick_hz() -> float:
    return float(schema()["protocol"]["tick_hz"])


def _steps(system: System) -> list[str]:
    """Return that a table of points with straight lines between them has no steps."""
    if not isinstance(system.setpoint, Steps) or len(system.setpoint.levels_n) == 1:
        return []
    return [
        f'setpoint.kind = "steps": the device plays {STORE} points with straight lines between them, which miss steps '
        f"in a run above {STORE / _tick_hz():.2g} s; `frictionloop device set PORT setpoint.hold_n=LEVEL` sets a level"
    ]


def _beyond_position(system: System) -> list[str]:
    """Return that strokes go farther than the position sensor reads, where the board ends with a fault."""
    motion = system.motion
    if not isinstance(motion, Strokes) or not (wanted := scale_for(motion.stroke_mm, system)):
        return []
    m_per_count, half_mm = system.board.position_m_per_count, motion.stroke_mm / 2.0
    return [
        f"motion.stroke_mm = {motion.stroke_mm:g} mm: the position goes to {half_mm:g} mm from the middle, and is read "
        f"to {1e3 * COUNTS * abs(m_per_count):.3g} mm with {SCALE} = {m_per_count:g}, where the board stops with the "
        f"fault sensor_saturated; {wanted[SCALE]:.2g} reads all of it"
    ]


def scale_for(stroke_mm: float, system: System) -> dict[str, float]:
    """Return the scale of a board's position with which all of a stroke is read, by its name; empty where it is."""
    half_m, m_per_count = 5e-4 * stroke_mm, system.board.position_m_per_count
    beyond = m_per_count and half_m >= COUNTS * abs(m_per_count)
    return {SCALE: math.copysign(half_m / COUNTS * ROOM, m_per_count)} if beyond else {}


def _off_the_carrier(system: System, plate: ResonantPlate) -> list[str]:
    try:
        left = amplitude_left(plate, carrier_hz(system))
    except FrictionloopError as error:
        return [str(error)]
    ticks = period_ticks(system)
    if left >= LEAST_LEFT:
        return []
    said = f"plate.frequency_hz = {plate.frequency_hz:g} Hz: the nearest carrier is {carrier_said(system)}; "
    if plate.pulse_ticks == ticks:
        return [f"{said}plate.max_amplitude_um and that of controller.model are to be those at this carrier"]
    model = system.controller.model
    lower = {"plate": plate.max_amplitude_um, "controller.model": model.max_amplitude_um}
    there = {f"{block}.max_amplitude_um": left * largest_um for block, largest_um in lower.items()}
    flags = " ".join(f"--{path} {value:.4g}" for path, value in {"plate.pulse_ticks": ticks, **there}.items())
    return [f"{said}`{flags}` takes that into account, if these are the amplitudes at the resonance"]
