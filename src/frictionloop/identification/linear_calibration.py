"""A straight line through pairs: amplitude by a vibrometer, position by a stage, a resonance over time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from scipy.stats import linregress

from frictionloop.identification.estimate import Estimate, measured
from frictionloop.identification.project_entry_result import EntryResult, Sensor, not_told, thinned
from frictionloop.identification.project_file import Take
from frictionloop.identification.recording_columns import READING_UNITS, channel
from frictionloop.quantities import Array, must_be

BEYOND = 1.05
"""Drives beyond so many times the largest measured are said to be continued to (assumed)."""

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
        fitted = self.offset.value + self.slope.value * self.x
        return {**thinned(POINTS, x=self.x, y=self.y, fitted=fitted), "labels": [x, y]}


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
        raise must_be("recording: pairs", int(x.size), "4 or more, different")
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
    return CarrierDrift(line.slope, line.method, float(np.ptp(where)), per_kelvin, 60 * minutes, frequency)


def scale_entry(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor) -> EntryResult:
    """Return the amplitude in um per drive, and the largest one, from drives under a vibrometer."""
    pairs = [_pairs(run, take.frequency_hz) for run in runs]
    lines = [straight_scale(drive, amplitude, f"um/{unit or 'duty'}") for drive, amplitude, unit in pairs]
    how = f"line through {sum(line.x.size for line in lines)} drives"
    slopes, methods = [line.slope for line in lines], [line.method for line in lines]
    values = [measured("amplitude_scale", slopes, methods, how)]
    found = []
    if take.full_drive is not None:
        full, path = take.full_drive, "plate.max_amplitude_um"
        ends = [line.at(full, "um") for line in lines]
        values.append(measured(path, ends, [full * each for each in methods], f"{how}, at {full:g}"))
        largest = max(float(line.x.max()) for line in lines)
        if full > BEYOND * largest:
            found = [not_told(f"{path} at {full:g}", f"measured to {largest:g}")]
    unit = pairs[0][2]
    numbers = {"r2": [line.r2 for line in lines], "upper_less_lower_half_percent": [100 * line.bend for line in lines]}
    curves = lines[0].drawn(f"drive ({unit or 'duty'})", "amplitude (µm)")
    return EntryResult(values, found, numbers, [], {"pairs": curves})


def _pairs(run: xr.Dataset, frequency_hz: float | None) -> tuple[Array, Array, str]:
    dim = "row" if "row" in run.dims else "time"
    drive = channel(run, "drive", ("V", "", "counts"), dim=dim)
    if "vibration" in run and run["vibration"].attrs.get("units") == "m/s":
        if frequency_hz is None:
            raise must_be("frequency_hz", None, "a number for a vibration in m/s", "Hz")
        amplitude = 1e6 * channel(run, "vibration", ("m/s",), dim=dim) / (2 * math.pi * frequency_hz)
    else:
        amplitude = channel(run, "vibration", ("um",), dim=dim)
    if dim == "row":
        return drive, np.abs(amplitude), str(run["drive"].attrs["units"])
    # Over time: the mean of each level once it is still, its second half.
    edges = np.concatenate([[0], np.flatnonzero(np.diff(drive)) + 1, [drive.size]])
    levels = [(a + (b - a) // 2, b) for a, b in pairwise(edges.tolist()) if b - a >= 4]
    drives = np.array([drive[b - 1] for _, b in levels])
    means = np.array([float(np.abs(amplitude[a:b]).mean()) for a, b in levels])
    return drives, means, str(run["drive"].attrs["units"])


def carrier_entry(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor) -> EntryResult:
    """Return how fast the resonance drifts."""
    found = [carrier_drift(run) for run in runs]
    how = f"line through {found[0].frequency_hz.size} resonances"
    methods = [f.method_hz_per_min for f in found]
    values = [measured("carrier_drift", [f.rate for f in found], methods, how)]
    slopes = [f.per_kelvin for f in found if f.per_kelvin is not None]
    if slopes:
        values.append(measured("carrier_drift_per_kelvin", slopes, None, how))
    first = found[0]
    middle = float(first.frequency_hz.mean())
    numbers: dict[str, Any] = {"largest_less_least_hz": [f.span_hz for f in found]}
    for q in (150, 300):
        numbers[f"lost_at_q_{q}_percent"] = [100 * (1 - f.share_left(middle, q)) for f in found]
    curves = thinned(POINTS, x=first.time_s / 60, y=first.frequency_hz - middle)
    return EntryResult(values, [], numbers, [], {"drift": {**curves, "middle": middle}})


def position_entry(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor) -> EntryResult:
    """Return the scale of the position sensor from known ways: ``position`` in m and ``reading``."""
    found, unit = [], ""
    for run in runs:
        dim = "row" if "row" in run.dims else "time"
        known = channel(run, "position", ("m",), dim=dim)
        reading = channel(run, "reading", (*READING_UNITS, "m", ""), dim=dim)
        unit = str(run["reading"].attrs["units"])
        found.append(straight_scale(reading, known, f"m/{unit or 'reading'}"))
    how = f"line through {sum(line.x.size for line in found)} places"
    slopes, methods = [line.slope for line in found], [line.method for line in found]
    value = measured("position_scale", slopes, methods, how)
    numbers = {"r2": [line.r2 for line in found], "residual_um": [1e6 * line.residual for line in found]}
    overrides = {"board.position_m_per_count": value.value} if unit == "counts" else {}
    drawn = found[0].drawn(f"reading ({unit})", "position (m)")
    return EntryResult([value], [], numbers, [], {"pairs": drawn, "overrides": overrides})
