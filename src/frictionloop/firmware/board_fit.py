"""Does a system fit the board as its firmware is written? What would be wrong on it, before anything is built."""

from __future__ import annotations

import math

from frictionloop.parameters import ResonantPlate, System
from frictionloop.quantities.schema import schema

BUS_HZ, PERIOD = 36e6, 783
"""Clock and period of the carrier's timer (firmware/boards/teensy31/carrier.c)."""
CARRIER_HZ = BUS_HZ / PERIOD
LEAST_LEFT = 0.9
"""Share of the plate's amplitude at the carrier below which it is told (chosen)."""


def amplitude_left(plate: ResonantPlate) -> float:
    """Return the amplitude at the board's carrier over that at the plate's resonance, 1 / sqrt(1 + ((f - f0) / fc)^2).

    fc = f0 / (2 Q) is the corner of the envelope (docs/plate).
    """
    return 1.0 / math.hypot(1.0, (CARRIER_HZ - plate.frequency_hz) / plate.cutoff_hz)


def carrier_misses(system: System) -> bool:
    """Tell whether the board's carrier leaves the plate less than `LEAST_LEFT` of its amplitude."""
    return isinstance(system.plate, ResonantPlate) and amplitude_left(system.plate) < LEAST_LEFT


def misfits(system: System) -> list[str]:
    """Return what of a system the firmware does not do, a line each; nothing where all fits."""
    said, plate, rate_hz = [], system.plate, float(schema()["protocol"]["tick_hz"])
    if system.controller.rate_hz != rate_hz:
        said.append(
            f"controller.rate_hz = {system.controller.rate_hz:g} Hz: simulations run at it, the firmware at "
            f"{rate_hz:g} Hz; for a device design at that rate"
        )
    if isinstance(plate, ResonantPlate) and (left := amplitude_left(plate)) < LEAST_LEFT:
        said.append(
            f"plate.frequency_hz = {plate.frequency_hz:g} Hz: the board's carrier is at {CARRIER_HZ:.0f} Hz, where "
            f"this plate gives {100 * left:.2g} % of its amplitude; PERIOD = {BUS_HZ / plate.frequency_hz:.0f} in "
            "firmware/boards/teensy31/carrier.c fits it"
        )
    return said
