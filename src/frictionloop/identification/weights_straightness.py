"""Scales of a project from known quantities: weights on the force sensor, weights on the load cells, a known way."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.constants import g as STANDARD_GRAVITY
from scipy.stats import t as student

from frictionloop.findings import Finding
from frictionloop.identification.estimate import Estimate, measured
from frictionloop.identification.project_entry_result import EntryResult, Rows, Sensor, not_told, off_line
from frictionloop.identification.project_file import Take
from frictionloop.identification.recording_columns import READING, READING_UNITS, no_column
from frictionloop.identification.weights_calibration import (
    Calibration,
    Plateaus,
    PulleyFriction,
    line_through,
    pulley_friction,
    weights,
)
from frictionloop.quantities import FrictionloopError, must_be

SURE = 0.01
"""Chance below which a bend or a drift is called real (assumed)."""
FACTORS = {9.80665: "kg", 1000.0: "mN"}
"""Slopes in N/N that a unit taken for N makes, and the unit."""
HEAVY_KG = 20.0
"""Mass from which on grams are asked about (assumed)."""

HIDDEN = 1.5e-4
"""Relative error that a pulley on ball bearings leaves while a swinging hook hides its friction: b = 2.5e-4 of a
friction of 0.0015 (docs/calibration), over sqrt(3)."""
GRAVITY = 0.0015
"""The same of the standard gravity for that of an unknown place: 9.780 to 9.832 m/s^2, over sqrt(3)."""
STANDING, MOVING = 0.9, 0.7
"""A step of weights clips where more than the first share of its samples is at one end, and in the other steps less
than the second (assumed: with a coarse converter it is that much everywhere)."""
LEAST_WEIGHTS, ALONE = 5, 0.2
"""Weights from which one is judged by the others, and their scatter without it as a share of that with it (assumed)."""
APART = 0.05
"""Masses that differ by more than this share of the largest cannot give one reading (assumed: readings are rounded)."""


def weights_entry(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor) -> EntryResult:
    """Return sensitivity and offset; the errors that all weights share are those of the method."""
    gravity = take.gravity_m_s2 or STANDARD_GRAVITY
    lines = [weights(run, take.settle_s, gravity, take.tolerance) for run in runs]
    for line in lines:
        _refuse_clipped(line)
    found = list[Finding]()
    lines = [_labelled(line, gravity, take.tolerance, found) for line in lines]
    straight = [straightness(line) for line in lines]
    methods = []
    for line, left in zip(lines, straight, strict=True):
        bent = abs(left.curvature.value) if left.curved else 0.0
        apart = 0.0 if left.friction is None else abs(left.friction.sensitivity.value - line.sensitivity.value)
        shares = [bent, line.weights_error, _swing(line), HIDDEN, 0.0 if take.gravity_m_s2 else GRAVITY]
        share = float(np.linalg.norm(shares))
        methods.append(float(np.hypot(share * abs(line.sensitivity.value), apart / np.sqrt(3))))
    found += [each for left in straight for each in left.findings]
    found += [each for run in runs for each in _crosstalk(run, take, gravity)]
    entry = _of_lines(lines, "", [_safer(line) for line in lines], methods, take)
    return replace(entry, findings=[*found, *entry.findings])


def load_entry(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor) -> EntryResult:
    """Return the scale of the load cells from weights put on the plate, and what of a load the force sensor reads."""
    gravity = take.gravity_m_s2 or STANDARD_GRAVITY
    lines = [weights(_as_reading(run), take.settle_s, gravity, take.tolerance) for run in runs]
    slopes = [max(line.sensitivity, line.left_out, key=lambda each: each.standard_error) for line in lines]
    share = 0.0 if take.gravity_m_s2 else GRAVITY
    methods = [float(np.hypot(line.weights_error, share)) * abs(line.sensitivity.value) for line in lines]
    entry = _of_lines(lines, "load_", slopes, methods, take)
    values = [*entry.measured]
    if all(READING in run for run in runs):
        crossed = [weights(run, take.settle_s, gravity).sensitivity for run in runs]
        shares = [each.over(sensor.sensitivity, "N/N") for each in crossed]
        values.append(measured("crosstalk", shares, None, values[0].how))
    board = {"board.load_n_per_count": 1 / values[0].value, "board.load_zero_counts": round(values[1].value)}
    overrides = board if lines[0].steps.unit == "counts" else {}
    return replace(entry, measured=values, curves={**entry.curves, "overrides": overrides})


def _as_reading(run: xr.Dataset) -> xr.Dataset:
    if "load" not in run:
        raise no_column("load", run)
    return run.drop_vars(READING, errors="ignore").rename(load=READING)


def _of_lines(
    lines: Sequence[Calibration], name: str, slopes: Sequence[Estimate], methods: Sequence[float], take: Take
) -> EntryResult:
    """Return slope and offset of lines through weights, under a name, what scatters about them, and what is drawn."""
    unit, gravity = lines[0].steps.unit, take.gravity_m_s2 or STANDARD_GRAVITY
    how = f"line through {sum(line.steps.mass_kg.size for line in lines)} weights"
    slope = measured(f"{name}sensitivity", slopes, methods, how)
    offset = measured(f"{name}offset", [line.offset for line in lines], None, how)
    numbers = {"r2": [line.r2 for line in lines], "residual_mn": [1e3 * line.residual_rms_n for line in lines]}
    if loops := [100 * line.hysteresis for line in lines if np.isfinite(line.hysteresis)]:
        numbers["hysteresis_percent"] = loops
    rows: Rows = [("mass (g)", f"reading ({unit})", "residual (mN)")]
    curves: dict[str, Any] = {"unit": unit, "force_n": [], "reading": [], "residual_n": []}
    for line in lines:
        mass, reading, residual = line.steps.mass_kg, line.steps.reading, line.residuals_n
        parts = zip(mass, reading, residual, strict=True)
        rows += [(f"{1e3 * m:.4g}", f"{y:.6g}", f"{1e3 * r:+.3g}") for m, y, r in parts]
        curves["force_n"].append((mass * gravity).tolist())
        curves["reading"].append(reading.tolist())
        curves["residual_n"].append(residual.tolist())
    curves |= {"slope": slope.value, "offset": offset.value}
    given = Finding("TAKEN-FOR", value=f"{STANDARD_GRAVITY:.5f}", unit="m/s^2", more={"path": "gravity_m_s2"})
    return EntryResult([slope, offset], [] if take.gravity_m_s2 else [given], numbers, rows, curves)


def _refuse_clipped(line: Calibration) -> None:
    steps = line.steps
    at = clipped_steps(steps)
    if at.any():
        masses = ", ".join(f"{1e3 * mass:g}" for mass in np.unique(steps.mass_kg[at]))
        level = float(steps.reading[at][0])
        raise must_be(f"recording: f_m clipped under {masses} g", level, "within the range", steps.unit, "CLIPPED")


def clipped_steps(steps: Plateaus) -> NDArray[np.bool_]:
    """Return which steps of a calibration stand at an end of the sensor's range.

    Two different masses give exactly the same reading there, or the noise of the others is missing at that end.
    """
    found = np.zeros(steps.reading.size, dtype=bool)
    near = 1e-9 * float(np.ptp(steps.reading))
    for k, end in enumerate((float(steps.reading.min()), float(steps.reading.max()))):
        at = np.abs(steps.reading - end) <= near
        shares = steps.at_ends[:, k]
        others = float(np.median(shares[~at])) if not at.all() else 1.0
        several = float(np.ptp(steps.mass_kg[at])) > APART * float(np.ptp(steps.mass_kg))
        if several or (float(shares[at].max()) > STANDING and others < MOVING):
            found |= at
    return found


def _swing(line: Calibration) -> float:
    """Return the relative error that hooks which still swing leave in the sensitivity.

    A swing of phi changes the tension by (phi^2/4)(1 - 3 cos 2wt): what does not average out is 0.47 of the standard
    deviation of what does.
    """
    force = np.abs(line.steps.reading - line.offset.value)
    heavy = force > 0.5 * force.max()
    return 0.47 * float(np.sqrt(np.mean((line.steps.moves[heavy] / force[heavy]) ** 2)))


def _safer(line: Calibration) -> Estimate:
    """Return the sensitivity with the larger error of scatter and, with fewer than 12 steps, of leaving one out."""
    few = line.steps.mass_kg.size < 12
    return max(line.sensitivity, line.left_out, key=lambda e: e.standard_error) if few else line.sensitivity


def _crosstalk(run: xr.Dataset, take: Take, gravity: float) -> Iterator[Finding]:
    """Yield what other channels read of the force that the weights make."""
    for name in map(str, run.data_vars):
        if name in ("mass", READING) or run[name].attrs.get("units") not in READING_UNITS:
            continue
        if float(np.ptp(run[name].values)) == 0:
            continue
        line = weights(run.assign({READING: run[name]}), take.settle_s, gravity, take.tolerance).sensitivity
        if _real(line):
            yield off_line(f"crosstalk of {READING}", line.value, line.unit, name)


class Straightness(NamedTuple):
    """What a line through weights leaves."""

    curvature: Estimate
    """How much more the reading grows than the line, at the largest force over the span of the reading."""
    curved: bool
    drift: Estimate
    """Change of the residual from the first to the last step in N, the line taken off."""
    drifts: bool
    friction: PulleyFriction | None
    """None where it cannot be told."""
    findings: tuple[Finding, ...]


def straightness(found: Calibration) -> Straightness:
    """Return curvature, drift and friction of the pulley, each with its uncertainty, and what to say of them.

        residual_i = c (x_i^2 - x_i) span + d k_i + scatter,   x = (force - least)/span, k from 0 to 1 in order

    by least squares with the line's two parameters, where there are steps enough. Drift cannot be told from curvature
    when weights are only added: then curvature alone is fitted.

    Parameters
    ----------
    found : Calibration
        From `weights`.
    """
    mass = found.steps.mass_kg
    span = float(np.ptp(mass))
    x = (mass - mass.min()) / span
    order = np.linspace(0.0, 1.0, mass.size)
    unordered = bool(np.any(found.steps.direction < 0))
    columns = [np.ones_like(x), x, x**2 - x, *([order] if unordered else [])]
    span_n = span * STANDARD_GRAVITY
    bend, drift = _fitted(columns, found.residuals_n / span_n)
    curved, drifts = _real(bend), unordered and _real(drift)
    told = []
    if curved:
        told.append(off_line("bend", 100 * bend.value, "% of the span", "f_m"))
    if drifts:
        told.append(off_line("drift", 1e3 * drift.value * span_n, "mN", "f_m"))
    friction = None
    with suppress(FrictionloopError):
        friction = pulley_friction(found) if unordered else None
    if friction is None:
        told.append(not_told("friction of the pulley", "too few steps both ways"))
    elif _real(friction.exponent) and abs(friction.exponent.value) > 1e-3:
        told.append(off_line("friction of the pulley", 100 * friction.exponent.value, "%", "f_m"))
    told += _units(found)
    return Straightness(
        Estimate(bend.value / 4, bend.standard_error / 4, "", bend.freedom),
        curved,
        Estimate(drift.value * span_n, drift.standard_error * span_n, "N", drift.freedom),
        drifts,
        friction,
        tuple(told),
    )


def _labelled(line: Calibration, gravity_m_s2: float, tolerance: float, found: list[Finding]) -> Calibration:
    """Return the line without the weight without which the others scatter a fifth as much; what it reads is found."""
    mass, reading, unit, *rest = line.steps
    lines = [np.polyfit(np.delete(mass, k), np.delete(reading, k), 1) for k in range(mass.size)]
    left = [np.delete(reading - np.polyval(each, mass), k).std() for k, each in enumerate(lines)]
    k = int(np.argmin(left))
    alike = (reading[k] - lines[k][1]) / lines[k][0]
    if mass.size < LEAST_WEIGHTS or left[k] >= ALONE * np.median(left) or abs(alike - mass[k]) <= APART * np.ptp(mass):
        return line
    more = {"row": k + 1, "other": 1e3 * float(alike)}
    found.append(Finding("WEIGHT-LABEL", value=1e3 * float(mass[k]), unit="g", more=more))
    mass, reading, *rest = (np.delete(each, k, axis=0) for each in (mass, reading, *rest))
    return line_through(Plateaus(mass, reading, unit, *rest), gravity_m_s2, tolerance)


def _fitted(columns: list[NDArray[np.float64]], residual: NDArray[np.float64]) -> tuple[Estimate, Estimate]:
    """Return the third coefficient and the fourth, with standard errors; not known where there are too few steps."""
    matrix = np.stack(columns, axis=1)
    freedom = residual.size - matrix.shape[1]
    if freedom < 1 or np.linalg.matrix_rank(matrix) < matrix.shape[1]:
        return Estimate(0.0, np.inf, "", 1.0), Estimate(0.0, np.inf, "", 1.0)
    values, *_ = np.linalg.lstsq(matrix, residual, rcond=None)
    left = float(np.sum((residual - matrix @ values) ** 2)) / freedom
    errors = np.sqrt(left * np.diag(np.linalg.inv(matrix.T @ matrix)))
    found = [Estimate(float(v), float(e), "", freedom) for v, e in zip(values, errors, strict=True)]
    return found[2], found[3] if len(found) > 3 else Estimate(0.0, np.inf, "", 1.0)


def _real(found: Estimate) -> bool:
    """Return whether a value differs from 0 more than chance makes it."""
    if not np.isfinite(found.standard_error):
        return False
    return abs(found.value) > float(student.ppf(1 - SURE / 2, found.freedom)) * found.standard_error


def _units(found: Calibration) -> Iterator[Finding]:
    """Suspect aloud a slope or a mass that a wrong unit would make."""
    slope = abs(found.sensitivity.value)
    for factor, unit in FACTORS.items() if found.steps.unit == "N" else ():
        if abs(slope / factor - 1) < 0.1 or abs(slope * factor - 1) < 0.1:
            more = {"path": "sensitivity", "low": 0.5, "high": 2.0}
            yield Finding("UNIT-DOUBT", value=slope, unit="N/N", remedy=f"unit = {unit}", more=more)
    most = float(found.steps.mass_kg.max())
    if most > HEAVY_KG:
        more = {"path": "mass", "low": 0.0, "high": HEAVY_KG}
        yield Finding("UNIT-DOUBT", value=most, unit="kg", remedy="unit = g", more=more)
