"""A straight line through pairs: amplitude by a vibrometer, position by a stage, a resonance over time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.stats import linregress

from frictionloop.identification.measured import Estimate
from frictionloop.identification.recording_columns import channel
from frictionloop.quantities import must_be

Array = NDArray[np.float64]
POINTS = 800
"""Points that are drawn."""


@dataclass(frozen=True)
class Scale:
    """y = offset + slope x, and how straight that is."""

    slope: Estimate
    offset: Estimate
    method: float
    """Standard error of the slope: how far those of the lower and the upper half are apart."""
    residual: float
    """Standard deviation about the line, in the unit of y."""
    r2: float
    bend: float
    """Relative change of the slope from the lower half to the upper."""
    x: Array
    y: Array

    def at(self, x: float, unit: str) -> Estimate:
        """Return y at a place, with the error of slope and offset."""
        error = math.hypot(self.slope.standard_error * (x - self.x.mean()), self.residual / math.sqrt(self.x.size))
        return Estimate(self.offset.value + self.slope.value * x, error, unit, self.slope.freedom)

    def drawn(self, x: str, y: str) -> dict[str, Any]:
        """Return what is drawn, with the names of the axes."""
        step = max(self.x.size // POINTS, 1)
        fitted = self.offset.value + self.slope.value * self.x
        curves = {"x": self.x, "y": self.y, "fitted": fitted}
        return {name: each[::step].tolist() for name, each in curves.items()} | {"labels": [x, y]}


def straight_scale(x: Array, y: Array, unit: str = "") -> Scale:
    """Return the line through pairs by least squares, its error the larger one of scatter and of the jackknife.

    Parameters
    ----------
    x, y : array
        Pairs, at least four, x not all alike.
    unit : str
        Unit of y over that of x.

    Raises
    ------
    FrictionloopError
        For too few pairs, or an x that does not change.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if x.size < 4 or x.size != y.size or np.ptp(x) == 0:
        raise must_be("recording: pairs", int(x.size), "4 or more, not all alike")
    line = linregress(x, y)
    residuals = y - line.intercept - line.slope * x
    away = (x - x.mean()) ** 2
    leverage = 1 / x.size + away / away.sum()
    # Leaving out one pair moves the slope by this much (closed form), and the jackknife sums that up.
    moved = (x - x.mean()) * residuals / (1 - leverage) / away.sum()
    left_out = math.sqrt((x.size - 1) / x.size * float(np.sum((moved - moved.mean()) ** 2)))
    low = x <= np.median(x)
    slopes = [float(np.polyfit(x[part], y[part], 1)[0]) if np.ptp(x[part]) else line.slope for part in (low, ~low)]
    apart = abs(slopes[1] - slopes[0]) / 2
    freedom = x.size - 2.0
    return Scale(
        Estimate(float(line.slope), max(float(line.stderr), left_out), unit, freedom),
        Estimate(float(line.intercept), float(line.intercept_stderr), "", freedom),
        max(apart**2 - 2 * float(line.stderr) ** 2, 0.0) ** 0.5 / math.sqrt(3),
        float(np.sqrt(np.sum(residuals**2) / freedom)),
        float(line.rvalue**2),
        (slopes[1] - slopes[0]) / line.slope,
        x,
        y,
    )


@dataclass(frozen=True)
class CarrierDrift:
    """The drift of a resonance."""

    rate: Estimate
    """Hz per minute, a straight line over the whole time."""
    method_hz_per_min: float
    """Standard error of the method: how far the two halves are apart."""
    span_hz: float
    """Largest less least resonance."""
    per_kelvin: Estimate | None
    """Hz per kelvin, where the temperature was recorded."""
    time_s: Array
    frequency_hz: Array

    def share_left(self, resonance_hz: float, q: float) -> float:
        """Return the amplitude that a carrier at the one end keeps at the other: 1/sqrt(1 + (2 Q df/f0)^2)."""
        return 1 / math.hypot(1.0, 2 * q * self.span_hz / resonance_hz)


def carrier_drift(recording: xr.Dataset) -> CarrierDrift:
    """Return how a resonance that was tracked, or measured again and again, moves.

    Parameters
    ----------
    recording : xarray.Dataset
        ``frequency`` in Hz, and ``temperature`` in degC if known, over ``time`` in s; or a table with ``minutes``.

    Raises
    ------
    FrictionloopError
        For a column that is missing, fewer than four measurements, or times that are all alike.
    """
    dim = "row" if "row" in recording.dims else "time"
    frequency = channel(recording, "frequency", ("Hz",), dim=dim)
    if dim == "row":
        minutes = channel(recording, "minutes", ("min", "s", ""), dim=dim)
        minutes = minutes / 60 if recording["minutes"].attrs["units"] == "s" else minutes
    else:
        minutes = np.asarray(recording["time"].values, dtype=float) / 60
    if frequency.size < 4:
        raise must_be("recording: values of frequency", int(frequency.size), "at least 4")
    when, where = minutes, frequency
    # A tracked resonance wanders from sample to sample: means of a twentieth are taken for independent.
    if frequency.size > 40:
        when, where = (np.array([part.mean() for part in np.array_split(each, 20)]) for each in (minutes, frequency))
    line = straight_scale(when, where, "Hz/min")
    per_kelvin = None
    if "temperature" in recording:
        temperature = channel(recording, "temperature", ("degC", "K", ""), dim=dim)
        per_kelvin = straight_scale(temperature, frequency, "Hz/K").slope
    return CarrierDrift(
        line.slope, line.method, float(np.ptp(where)), per_kelvin, 60 * minutes, frequency,
    )  # fmt: skip
