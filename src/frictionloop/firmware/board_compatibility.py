"""Does a system fit the board as its firmware is written? What would be otherwise on it, before anything is built."""

from __future__ import annotations

import math
from collections.abc import Iterator

from frictionloop.analysis.operating_point import force_band, law_at
from frictionloop.findings import Condition, Finding
from frictionloop.firmware.effect_tables import STORE
from frictionloop.parameters import ResonantPlate, Steps, Strokes, SuspendedSensor, System
from frictionloop.physics.friction import friction_force
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.protocol_schema import schema

BUS_HZ = 132e6
"""Clock of the carrier's timer."""
USUAL_TICKS = 2870
"""Period of the carrier in an image for no certain plate: 46 kHz, as the paper's."""
MOST_TICKS = 32766
"""Longest period whose product with a duty the board has room for."""
CHIP_BITS = 12
"""Of the converters of a Teensy 4.1."""
COUNTS, ROOM = 2**15 - 1, 1.1
"""Largest reading of a converter, and what a stroke leaves of it free (chosen)."""
SCALE = "board.position_m_per_count"
"""Of the position sensor; negative where it counts the other way."""
LEAST_LEFT = 0.9
"""Share of the plate's amplitude at the carrier below which it is told (chosen)."""
FIRST_UM = 0.5
"""Ceiling that is proposed for a first run (assumed)."""


def period_ticks(system: System) -> int:
    """Return the period of the carrier in the image of a system, in ticks of its timer: the nearest to the plate."""
    plate = system.plate
    if not isinstance(plate, ResonantPlate):
        return USUAL_TICKS
    ticks = round(BUS_HZ / plate.frequency_hz)
    if not 2 <= ticks <= MOST_TICKS:
        accepted = f"{BUS_HZ / MOST_TICKS:.0f} to {BUS_HZ / 2:.3g} Hz on this board"
        raise must_be("plate.frequency_hz", plate.frequency_hz, accepted, "Hz", "BOARD-CARRIER")
    return ticks


def carrier_hz(system: System) -> float:
    """Return the frequency of the carrier in the image of a system."""
    return BUS_HZ / period_ticks(system)


def amplitude_left(plate: ResonantPlate, at_hz: float) -> float:
    """Return the amplitude at a carrier over that at the plate's resonance, 1 / sqrt(1 + ((f - f0) / fc)^2).

    fc = f0 / (2 Q) is the corner of the envelope (docs/plate).
    """
    return 1.0 / math.hypot(1.0, (at_hz - plate.frequency_hz) / plate.cutoff_hz)


def board_findings(system: System) -> Iterator[Finding]:
    """Yield what of a system the board does otherwise; nothing where all fits."""
    yield from gain_findings(system)
    yield from _beyond_position(system)
    yield from _steps(system)


def gain_findings(system: System) -> Iterator[Finding]:
    """Yield of these what takes other gains, or another amplitude."""
    plate, wanted = system.plate, system.controller.rate_hz
    nearest = float(min(schema()["rates"]["hz"], key=lambda rate: abs(rate - wanted)))
    if wanted != nearest:
        yield Finding("BOARD-RATE", value=wanted, unit="Hz", limit=nearest, remedy={"controller.rate_hz": nearest})
    if isinstance(plate, ResonantPlate):
        yield from _off_the_carrier(system, plate)


def converter_findings(system: System) -> Iterator[Finding]:
    """Yield that the converters on the chip are coarser than the file's."""
    sensor = system.sensor
    if isinstance(sensor, SuspendedSensor) and sensor.adc_bits > CHIP_BITS:
        remedy = {"sensor.adc_bits": CHIP_BITS}
        yield Finding("BOARD-BITS", value=sensor.adc_bits, limit=CHIP_BITS, remedy=remedy)


def ceiling_findings(system: System) -> Iterator[Finding]:
    """Yield which force the board's ceiling leaves out, just landed; without a ceiling, that a first run has one."""
    ceiling_um = system.board.ceiling_um
    if ceiling_um is None:
        remedy = {"board.ceiling_um": FIRST_UM}
        yield Finding("FIRST-RUN", value=system.plate.max_amplitude_um, unit="um", remedy=remedy)
        return
    try:
        least_n, wanted = float(friction_force(ceiling_um, law_at(system))), force_band(system)
    except FrictionloopError:  # a recording whose level is not known
        return
    if wanted.low_n < least_n:
        where, more = Condition(occluded=0.0), {"ceiling_um": ceiling_um, "high_n": wanted.high_n}
        yield Finding("CEILING-REACH", value=wanted.low_n, unit="N", limit=least_n, where=where, more=more)


def scale_for(stroke_mm: float, system: System) -> dict[str, float]:
    """Return the scale of a board's position with which all of a stroke is read, by its name; empty where it is."""
    half_m, m_per_count = 5e-4 * stroke_mm, system.board.position_m_per_count
    beyond = m_per_count and half_m >= COUNTS * abs(m_per_count)
    return {SCALE: math.copysign(half_m / COUNTS * ROOM, m_per_count)} if beyond else {}


def _steps(system: System) -> Iterator[Finding]:
    """Yield that a table of points with straight lines between them has no steps."""
    if isinstance(system.setpoint, Steps) and len(system.setpoint.levels_n) > 1:
        yield Finding("BOARD-STEPS", value=STORE / system.controller.rate_hz, unit="s", limit=STORE)


def _beyond_position(system: System) -> Iterator[Finding]:
    """Yield that strokes go farther than the position sensor reads, where the board ends with a fault."""
    motion = system.motion
    if isinstance(motion, Strokes) and (wanted := scale_for(motion.stroke_mm, system)):
        read_mm = 1e3 * COUNTS * abs(system.board.position_m_per_count)
        remedy = {SCALE: float(f"{wanted[SCALE]:.2g}")}
        yield Finding("BOARD-POSITION", value=motion.stroke_mm / 2.0, unit="mm", limit=read_mm, remedy=remedy)


def _off_the_carrier(system: System, plate: ResonantPlate) -> Iterator[Finding]:
    ticks = min(max(round(BUS_HZ / plate.frequency_hz), 2), MOST_TICKS)
    at_hz = BUS_HZ / ticks
    left = amplitude_left(plate, at_hz)
    if left >= LEAST_LEFT:
        return
    told = plate.pulse_ticks == ticks  # whoever gives it gives the amplitudes there
    model = system.controller.model
    lower = {"plate": plate.max_amplitude_um, "controller.model": model.max_amplitude_um}
    there = {f"{block}.max_amplitude_um": float(f"{left * um:.4g}") for block, um in lower.items()}
    yield Finding(
        "BOARD-CARRIER",
        severity="note" if told else None,
        value=plate.frequency_hz,
        unit="Hz",
        limit=at_hz,
        remedy="" if told else {"plate.pulse_ticks": ticks, **there},
        more={"share": 100.0 * left},
    )
