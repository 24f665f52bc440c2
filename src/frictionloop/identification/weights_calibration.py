"""Reading over force: the steps of weights, the straight line of Fig. 4a, and what scatters about it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.constants import g as STANDARD_GRAVITY
from scipy.optimize import brentq, least_squares
from scipy.stats import linregress

from frictionloop.identification.estimate import Estimate
from frictionloop.identification.recording_columns import READING, READING_UNITS, channel, no_column, rate_of
from frictionloop.identification.recording_file import Run
from frictionloop.quantities import Array, must_be
from frictionloop.quantities.value_checks import ABOVE_0, BELOW_1, number

CLEAR = 0.5
"""The largest jump that is none is below this share of the least that is one (assumed)."""
MASSES = "3 or more, different, from 0"
"""Accepted masses."""


class Plateaus(NamedTuple):
    """Means of the reading over the time a mass hangs still, in the order of the recording; arrays of one shape."""

    mass_kg: Array
    reading: Array
    """In ``unit``."""
    unit: str
    moves: Array
    """Standard deviation of the slow movement of the reading while a mass hangs, its swing; 0 of a table."""
    at_ends: Array
    """Share of the samples of a step at its least and at its largest value, shape (steps, 2); 0 of a table."""

    @property
    def direction(self) -> Array:
        """1 if the mass had grown, -1 if it had shrunk, 0 for the first."""
        return np.concatenate([[0.0], np.sign(np.diff(self.mass_kg))])


def plateaus(recording: xr.Dataset, settle_s: float = 1.0) -> Plateaus:
    """Return the steps of a calibration: where ``mass`` (kg) stays the same, the mean of ``f_m`` once it is still.

    The rows of a table are such steps as they stand.

    Parameters
    ----------
    recording : xarray.Dataset
        Columns ``mass`` in kg and ``f_m`` in N, V or counts, over ``time`` in s, or over ``row``.
    settle_s : float
        Time left out after each change of mass in s, not negative.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, a negative mass, fewer than three steps, all of one mass, or a
        step that does not last longer than ``settle_s``.
    """
    if isinstance(recording, xr.Dataset) and "row" in recording.dims:
        return _rows(recording)
    mass = channel(recording, "mass", ("kg",))
    reading = channel(recording, READING, READING_UNITS)
    rate_hz = rate_of(recording)
    number("settle_s", settle_s, "s", 0.0)
    if np.any(mass < 0):
        raise must_be("recording: mass", float(mass.min()), "at least 0", "kg")
    starts = np.concatenate([[0], np.flatnonzero(np.diff(mass)) + 1])
    ends = np.concatenate([starts[1:], [mass.size]])
    if starts.size < 3 or np.ptp(mass) == 0:
        raise must_be("recording: steps of mass", int(starts.size), "3 or more, different")
    shortest = int(np.argmin(ends - starts))
    lasts_s = (ends[shortest] - starts[shortest]) / rate_hz
    skipped = math.ceil(settle_s * rate_hz)
    if ends[shortest] - starts[shortest] <= skipped:
        raise must_be("settle_s", float(settle_s), f"below {lasts_s:g}, of row {starts[shortest]}", "s")
    hanging = [reading[a + skipped : b] for a, b in zip(starts, ends, strict=True)]
    means = np.array([each.mean() for each in hanging])
    moves = np.array([np.std([part.mean() for part in np.array_split(each, 10) if part.size]) for each in hanging])
    levels = mass[starts]
    at_ends = np.array([[np.mean(each == end) for end in (each.min(), each.max())] for each in hanging])
    return Plateaus(levels, means, str(recording[READING].attrs["units"]), moves, at_ends)


def _rows(table: xr.Dataset) -> Plateaus:
    mass = channel(table, "mass", ("kg",), dim="row")
    reading = channel(table, READING, READING_UNITS, dim="row")
    if mass.size < 3 or np.ptp(mass) == 0 or mass.min() < 0:
        raise must_be("recording: mass", f"{mass.size} rows, {mass.min():g} to {mass.max():g} kg", MASSES)
    unit, none = str(table[READING].attrs["units"]), np.zeros_like(reading)
    return Plateaus(mass, reading, unit, none, np.zeros((reading.size, 2)))


@dataclass(frozen=True)
class Calibration:
    """A straight line through the steps of a calibration, reading = offset + sensitivity * force."""

    sensitivity: Estimate
    """Unit of the reading per N."""
    offset: Estimate
    """In the unit of the reading."""
    left_out: Estimate
    """The sensitivity with the jackknife's error, from leaving each step out: of few steps the safer one."""
    r2: float
    """1 - sum of squared residuals over that of the readings about their mean."""
    residual_rms_n: float
    """Standard deviation of a step about the line (two parameters taken off), as a force in N."""
    load_std_n: float
    """Standard deviation of the forces in N; residual_rms_n is about sqrt(1 - r2) of it."""
    hysteresis: float
    """Largest difference between two visits of one mass, up and down, over the span; NaN without such visits."""
    weights_error: float
    """Relative standard error of the sensitivity that the tolerance of the weights makes; 0 if none is told."""
    steps: Plateaus
    residuals_n: Array
    """Residual of every step as a force in N."""

    def force_n(self, reading: Array | float) -> Array:
        """Return the force in N that a reading stands for."""
        return np.asarray((np.asarray(reading, dtype=float) - self.offset.value) / self.sensitivity.value)


def weights(
    recording: xr.Dataset, settle_s: float = 1.0, gravity_m_s2: float = STANDARD_GRAVITY, tolerance: float = 0.0
) -> Calibration:
    """Return sensitivity, offset and straightness from weights, by least squares over the steps.

        reading_i = offset + sensitivity * m_i g + residual_i

    Errors in variables: a weight's mark is fixed and its mass scatters about it (Berkson's case), so the slope is not
    lowered as by noise in the abscissa. The errors appear as scatter, yet hardly average out: a weight that hangs twice
    errs twice alike. ``weights_error`` is what they do to the slope for masses uniform within +-tolerance, each its
    own. Errors that all steps share (gravity, a pulley that always drags the same way) change the slope unseen;
    standard errors know nothing of them. `pulley_friction` finds a drag from steps up and down.

    Parameters
    ----------
    recording : xarray.Dataset
        Columns ``mass`` in kg and ``f_m`` in N, V or counts, over ``time`` in s, or over ``row``: a line per weight.
    settle_s : float
        Time left out after each change of mass in s; a table has none.
    gravity_m_s2 : float
        Local gravity g in m/s^2, positive; the standard value is up to 0.3 % off.
    tolerance : float
        Relative tolerance of the weights, from 0 to below 1.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, too few steps, or a number out of range.
    """
    number("gravity_m_s2", gravity_m_s2, "m/s^2", ABOVE_0)
    number("tolerance", tolerance, "", 0.0, BELOW_1)
    return line_through(plateaus(recording, settle_s), gravity_m_s2, tolerance)


def line_through(steps: Plateaus, gravity_m_s2: float, tolerance: float) -> Calibration:
    """Return what `weights` does, from its steps."""
    force = steps.mass_kg * gravity_m_s2
    line = linregress(force, steps.reading)
    if line.slope == 0:
        raise must_be("recording: slope of f_m", 0.0, f"another column, in {steps.unit}", f"{steps.unit}/N")
    residuals = (steps.reading - line.intercept - line.slope * force) / line.slope
    freedom = force.size - 2
    unit = f"{steps.unit}/N"
    return Calibration(
        sensitivity=Estimate(float(line.slope), float(line.stderr), unit, freedom),
        offset=Estimate(float(line.intercept), float(line.intercept_stderr), steps.unit, freedom),
        left_out=Estimate(float(line.slope), _left_out(force, steps.reading), unit, freedom),
        r2=float(line.rvalue) ** 2,
        residual_rms_n=float(np.sqrt(np.sum(residuals**2) / freedom)),
        load_std_n=float(np.std(force, ddof=1)),
        hysteresis=_hysteresis(steps),
        weights_error=_weights_error(steps.mass_kg, tolerance),
        steps=steps,
        residuals_n=residuals,
    )


def _left_out(force: Array, reading: Array) -> float:
    """Return the jackknife error of the slope, sqrt((n - 1)/n sum (slope_i - mean)^2), step i left out of slope_i."""
    kept = [np.arange(force.size) != k for k in range(force.size)]
    slopes = np.array([np.polyfit(force[each], reading[each], 1)[0] for each in kept if np.ptp(force[each]) > 0])
    return math.sqrt((slopes.size - 1) / slopes.size * float(np.sum((slopes - slopes.mean()) ** 2)))


def _weights_error(mass_kg: Array, tolerance: float) -> float:
    """Return the standard deviation of sum w_i m_i e(m_i), w the weights of the slope, e uniform within +-tolerance."""
    away = mass_kg - mass_kg.mean()
    share = away * mass_kg / float(np.sum(away**2))
    together = [float(np.sum(share[mass_kg == mass])) for mass in np.unique(mass_kg)]
    return tolerance / math.sqrt(3) * math.hypot(*together)


def _hysteresis(steps: Plateaus) -> float:
    apart = []
    for mass in np.unique(steps.mass_kg):
        up, down = (steps.reading[(steps.mass_kg == mass) & (steps.direction == way)] for way in (1, -1))
        if up.size and down.size:
            apart.append(abs(float(up.mean() - down.mean())))
    return max(apart) / float(np.ptp(steps.reading)) if apart else math.nan


def hung(runs: Sequence[Run], masses_kg: Array) -> xr.Dataset:
    """Return a row for each weight: its mass in kg, and the mean of every channel while it hung."""
    if len(runs) != masses_kg.size:
        raise must_be("masses", int(masses_kg.size), f"{len(runs)}, as many as recordings")
    whole = [run for run in runs if isinstance(run, xr.Dataset)]
    if any(READING not in run for run in whole):
        raise no_column(READING, whole[0])
    rows = {
        str(name): ("row", np.array([float(run[name].mean()) for run in whole]), whole[0][name].attrs)
        for name in whole[0].data_vars
        if name != "mass"
    }
    return xr.Dataset({"mass": ("row", masses_kg, {"units": "kg"}), **rows}, attrs=whole[0].attrs)


def standing(run: Run, count: int, settle_s: float) -> list[Run]:
    """Return the stretches of a log while each of so many weights hung, from one jump of the reading to the next.

    A jump is where the means of a quarter of a usual stretch before and after it differ most.
    """
    if not isinstance(run, xr.Dataset) or "time" not in run.dims or count < 2:
        return [run]
    reading, rate_hz = channel(run, READING, READING_UNITS), rate_of(run)
    width = max(reading.size // (4 * count), 2)
    sums = np.concatenate([[0.0], np.cumsum(reading - reading.mean())])
    apart = np.abs(sums[2 * width :] - 2 * sums[width:-width] + sums[: -2 * width]) / width
    jumps: list[int] = []
    sizes: list[float] = []
    for _ in range(count):
        row = int(np.argmax(apart))
        jumps, sizes = [*jumps, row + width], [*sizes, float(apart[row])]
        apart[max(row - width, 0) : row + width] = 0.0
    if not sizes[-1] < CLEAR * sizes[-2]:
        more = sum(size >= CLEAR * sizes[-2] for size in sizes) + 1
        raise must_be("masses_g", count, f"as many as plateaus: {more}")
    edges, skipped = [0, *sorted(jumps[:-1]), reading.size], math.ceil(settle_s * rate_hz)
    if (shortest := min(np.diff(edges))) <= 1.1 * skipped:
        raise must_be("settle_s", settle_s, f"below {shortest / rate_hz:.3g}", "s")
    return [run.isel(time=slice(a + skipped, b - (b - a) // 20)) for a, b in pairwise(edges)]


@dataclass(frozen=True)
class PulleyFriction:
    """The friction of a pulley, and the sensitivity freed from it."""

    exponent: Estimate
    """b: when a weight is put on e^-b of it arrives, when one is taken off up to e^b."""
    drag: Estimate
    """Force that is lost whatever the weight, N."""
    sensitivity: Estimate
    """Unit of the reading per N, with friction apart."""


def arriving(force_n: Array, direction: Array, exponent: float, drag_n: float = 0.0) -> Array:
    """Return what arrives of forces F that follow each other: the friction of the string acts against its motion.

    up: T = max(T before, e^-b F - d),   down: T = min(T before, e^b F + d),   at first T = F
    """
    rising = np.exp(-exponent) * force_n - drag_n
    falling = np.exp(exponent) * force_n + drag_n
    arrived = [float(force_n[0])]
    for k in range(1, force_n.size):
        arrived.append(max(arrived[-1], rising[k]) if direction[k] > 0 else min(arrived[-1], falling[k]))
    return np.array(arrived)


def pulley_friction(calibration: Calibration, gravity_m_s2: float = STANDARD_GRAVITY) -> PulleyFriction:
    """Return the friction of the pulley from a calibration that went up and down.

    Least squares of reading = offset + k T over offset, k, b and d, T as in `arriving`; standard errors from its
    Jacobian. A swing that shakes the pulley loose lowers b: what is found is the friction that was left, not that of
    the bearing. Friction that acts the same way at all steps cannot be told from the sensitivity.

    Parameters
    ----------
    calibration : Calibration
        From `weights`, with weights put on and taken off.
    gravity_m_s2 : float
        As given to `weights`.

    Raises
    ------
    FrictionloopError
        For fewer than six steps, or fewer than two up or two down.
    """
    steps = calibration.steps
    force, way = steps.mass_kg * gravity_m_s2, steps.direction
    up, down = int(np.sum(way > 0)), int(np.sum(way < 0))
    if force.size < 6 or min(up, down) < 2:
        raise must_be("recording: steps of mass", f"{up} up, {down} down", "6 or more, both ways")
    scale, span_n = calibration.sensitivity.value, float(np.ptp(force))

    def residuals(x: Array) -> Array:
        given = x[0] * span_n + x[1] * arriving(force, way, x[2], x[3] * span_n)
        return (given - steps.reading / scale) / span_n

    starts = [np.array([calibration.offset.value / scale / span_n, 1.0, b, 0.0]) for b in (0.0, 0.05, 0.2)]
    fits = [least_squares(residuals, start, xtol=1e-15, ftol=1e-15, gtol=1e-15) for start in starts]
    best = min(fits, key=lambda fit: float(fit.cost))
    freedom = force.size - 4
    error = np.sqrt(np.diag(np.linalg.pinv(best.jac.T @ best.jac)) * 2 * best.cost / freedom).tolist()
    _, k, exponent, drag = best.x.tolist()
    return PulleyFriction(
        Estimate(exponent, error[2], "", freedom),
        Estimate(drag * span_n, error[3] * span_n, "N", freedom),
        Estimate(k * scale, error[1] * abs(scale), calibration.sensitivity.unit, freedom),
    )


def r2_with_friction(loads_n: Sequence[float], exponent: float) -> float:
    """Return R2 of a perfect sensor calibrated up and down these loads over a pulley with friction b.

    For many loads from 0 and small b, 1/R2 - 1 is close to 4 b^2 (less what the first steps down, where the string has
    not begun to slip back, take off).

    Parameters
    ----------
    loads_n : sequence of float
        Rising loads in N, at least two, none negative; the last is visited once, the others twice.
    exponent : float
        b, not negative (`friction_exponent` of identification/rigs/weights).

    Raises
    ------
    FrictionloopError
        For loads that do not rise, or a negative exponent.
    """
    loads = np.asarray(loads_n, dtype=float)
    if loads.ndim != 1 or loads.size < 2 or not np.all(np.diff(loads) > 0) or loads[0] < 0:
        raise must_be("loads_n", loads.tolist(), "rising from 0 on", "N")
    number("exponent", exponent, "", 0.0)
    visits = np.concatenate([loads, loads[-2::-1]])
    way = np.sign(np.diff(visits, prepend=visits[0]))
    return float(linregress(visits, arriving(visits, way, exponent)).rvalue) ** 2


def exponent_for_r2(r2: float, loads_n: Sequence[float]) -> float:
    """Return the friction b of a pulley that lowers R2 to this value, the inverse of `r2_with_friction`.

    Parameters
    ----------
    r2 : float
        From 0.5 to below 1.
    loads_n : sequence of float
        As there.

    Raises
    ------
    FrictionloopError
        For an R2 out of range, or that no friction gives with these loads.
    """
    number("r2", r2, "", 0.5, BELOW_1)
    strongest = 2.0
    while r2_with_friction(loads_n, strongest) > r2 and strongest < 16:
        strongest *= 2
    if strongest >= 16:
        raise must_be("r2", r2, f"higher with {len(loads_n)} loads")
    return float(brentq(lambda b: r2_with_friction(loads_n, b) - r2, 0.0, strongest, xtol=1e-12))
