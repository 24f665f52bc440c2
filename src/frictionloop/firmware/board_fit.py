"""Does a system fit the board as its firmware is written? What would be wrong on it, before anything is built."""

from __future__ import annotations

import math
import re

from frictionloop.parameters import ResonantPlate, System
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.schema import firmware_folder, schema

BUS_HZ = 36e6
"""Clock of the carrier's timer."""
SOURCE = "boards/teensy31/carrier.c"
"""File with its period, in the firmware's folder."""
LEAST_LEFT = 0.9
"""Share of the plate's amplitude at the carrier below which it is told (chosen)."""


def period_ticks() -> int:
    """Return the carrier's period in an image that is built here, in ticks of its timer.

    Raises
    ------
    FrictionloopError
        Where the source does not give it as one number.
    """
    found = re.search(r"^\s*PERIOD\s*=\s*([1-9]\d*)\s*,", (firmware_folder() / SOURCE).read_text("utf-8"), re.MULTILINE)
    if found is None:
        raise FrictionloopError(
            f"firmware/{SOURCE}: has no PERIOD = NUMBER, so where its carrier is is not known; write it as one number"
        )
    return int(found[1])


def carrier_hz() -> float:
    """Return the frequency of the carrier in an image that is built here."""
    return BUS_HZ / period_ticks()


def amplitude_left(plate: ResonantPlate) -> float:
    """Return the amplitude at the board's carrier over that at the plate's resonance, 1 / sqrt(1 + ((f - f0) / fc)^2).

    fc = f0 / (2 Q) is the corner of the envelope (docs/plate).
    """
    return 1.0 / math.hypot(1.0, (carrier_hz() - plate.frequency_hz) / plate.cutoff_hz)


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
            f"plate.frequency_hz = {plate.frequency_hz:g} Hz: the board's carrier is at {carrier_hz():.0f} Hz, in an "
            f"image that is built here (PERIOD = {period_ticks()}); there this plate gives {100 * left:.2g} % of its "
            f"amplitude; PERIOD = {BUS_HZ / plate.frequency_hz:.0f} in firmware/{SOURCE} fits it"
        )
    return said
