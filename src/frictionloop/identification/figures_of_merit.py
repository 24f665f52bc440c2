"""What the printed figures of a force sensor imply, as plain formulas: R2, floor, dynamic range."""

from __future__ import annotations

import math
from typing import NamedTuple

from frictionloop.quantities.checks import ABOVE_0, number

HANN_BINS = 1.5
"""Equivalent noise bandwidth of a Hann window in bins."""


def residual_share(r2: float) -> float:
    """Return the residual's standard deviation over that of the readings, sqrt(1 - R2); R2 = 0.95 gives 0.22.

    Raises ``FrictionloopError`` for an R2 outside 0 to 1.
    """
    return math.sqrt(1 - number("r2", r2, "", 0.0, 1.0))


def uniform_std_n(range_n: float = 2.5) -> float:
    """Return the standard deviation of loads spread evenly from 0 to the range, range/sqrt(12)."""
    return number("range_n", range_n, "N", ABOVE_0) / math.sqrt(12)


def dynamic_range_db(range_n: float, floor_n: float) -> float:
    """Return 20 log10(range/floor); 2.5 N over 5e-5 N is 93.98 dB. Raises ``FrictionloopError`` if not positive."""
    return 20 * math.log10(number("range_n", range_n, "N", ABOVE_0) / number("floor_n", floor_n, "N", ABOVE_0))


class FloorReading(NamedTuple):
    """A printed floor under one reading of the word."""

    density_n_rthz: float
    rms_n: float
    """Standard deviation behind the low-pass."""
    range_db: float
    """Range over that rms."""


def floor_readings(
    floor_n: float = 5e-5, cutoff_hz: float = 300.0, bin_hz: float = 0.1, range_n: float = 2.5
) -> dict[str, FloorReading]:
    """Return what a floor means as rms, as density and per bin of a spectrum, behind a first-order pole.

        rms = density sqrt(pi/2 cutoff),   per bin: density = floor/sqrt(bin * 1, or 1.5 with a Hann window)

    Parameters
    ----------
    floor_n : float
        The printed number, 5e-5 (paper, Sec. 3.3).
    cutoff_hz : float
        Low-pass in Hz, 300 (paper, Sec. 3.3).
    bin_hz : float
        Distance of frequencies in Hz; 0.1 for a sample of 10 s (paper, Sec. 3.3).
    range_n : float
        Largest force in N, 2.5 (paper, Sec. 3.1).

    Raises
    ------
    FrictionloopError
        For a number that is not positive.
    """
    floor = number("floor_n", floor_n, "N", ABOVE_0)
    width = math.sqrt(math.pi / 2 * number("cutoff_hz", cutoff_hz, "Hz", ABOVE_0))
    bin_ = number("bin_hz", bin_hz, "Hz", ABOVE_0)
    densities = {
        "rms": floor / width,
        "density": floor,
        "per bin": floor / math.sqrt(bin_),
        "per bin, Hann": floor / math.sqrt(HANN_BINS * bin_),
    }
    return {
        name: FloorReading(density, density * width, dynamic_range_db(range_n, density * width))
        for name, density in densities.items()
    }
