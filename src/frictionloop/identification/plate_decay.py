"""Resonance, Q and corner of the plate from how its vibration rises or falls after a jump of the drive."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.ndimage import binary_closing
from scipy.optimize import least_squares

from frictionloop.identification.estimate import Estimate, measured
from frictionloop.identification.frequency_response import sandwich
from frictionloop.identification.linear_calibration import POINTS
from frictionloop.identification.matrix_pencil import damped
from frictionloop.identification.plate_sweep import VIBRATIONS, PlateResonance, plate_sweep, stepped
from frictionloop.identification.project_entry_result import EntryResult, Sensor, thinned
from frictionloop.identification.project_file import Take
from frictionloop.identification.recording_columns import channel, rate_of
from frictionloop.quantities import Array, must_be

CORNER = "controller.model.plate_hz"

Ring = tuple[float, float, float, float, float, Array]
WORST_MISFIT = 0.1
"""Most of a rise or fall that one time constant may leave unexplained (assumed)."""
LEAST_JUMP = 0.3
"""A jump is a change by more than this share of the largest (assumed)."""
CONSTANTS = 8.0
"""So many time constants after a jump are fitted: e^-8 is left."""


def jumps_of(envelope: Array, size: int) -> list[tuple[int, int, bool]]:
    """Return from where to where each fall lasts, from its steepest place to just before the next jump, and True.

    Without a fall these are the rises, and False: a rise beats where the drive is beside the resonance, a fall never
    does.
    """
    step = np.abs(envelope[2 * size :] - envelope[: -2 * size])
    largest = float(np.percentile(envelope, 99.5))
    # How long a rise takes is not known beforehand: twice the shortest stretch over which one is a jump is taken.
    edges, starts = np.zeros((0, 2), dtype=int), []
    for wide in (envelope.size // share for share in (400, 200, 100, 50)):
        found_before = edges.size > 0
        change = np.abs(envelope[2 * wide :] - envelope[: -2 * wide]) if wide > 0 else np.zeros(0)
        high = np.concatenate([[False], change > LEAST_JUMP * largest, [False]])
        # What flickers about the threshold is one jump.
        high = binary_closing(np.pad(high, 4 * wide), np.ones(4 * wide + 1))[4 * wide : -4 * wide or None]
        edges = np.flatnonzero(np.diff(high.astype(np.int8))).reshape(-1, 2)
        if found_before:
            break
    for a, b in edges.tolist():
        inner = slice(max(a + wide - 2 * size, 0), min(b + wide + 2 * size, step.size))
        starts.append(inner.start + int(np.argmax(step[inner])) + size)
    starts = [k for k in starts if k > 3 * size]
    stops = [*(k - 3 * size for k in starts[1:]), envelope.size - size]
    found = [(a, b) for a, b in zip(starts, stops, strict=False) if b - a > 20 * size]
    if not found:
        raise must_be("recording: jumps of the vibration", 0, f"1 or more, by {LEAST_JUMP:.0%}")
    falls = [(a, b, True) for a, b in found if envelope[b - 2 * size : b].mean() < 0.3 * envelope[a - 3 * size]]
    return falls or [(a, b, False) for a, b in found]


def plate_decay(recording: xr.Dataset) -> PlateResonance:
    """Return resonance and Q from the vibration itself, sampled above twice the resonance, after the drive jumps.

        y(t) = c + e^(-w t/(2 Q)) (a cos w_d t + b sin w_d t) + (what the drive holds, at its own frequency)

    by least squares for each rise or fall; the estimate is the mean, their scatter its standard error, and that of a
    single one the fit's own. The method's error is how far the values move when the fit begins a time constant later.

    Parameters
    ----------
    recording : xarray.Dataset
        ``vibration`` in um, m/s or V over ``time`` in s; the jumps are found in it.

    Raises
    ------
    FrictionloopError
        For a column that is missing, no jump, a rate too low, or a decay that one resonance does not explain.
    """
    y, rate_hz = channel(recording, "vibration", VIBRATIONS), rate_of(recording)
    y = y - y.mean()
    spectrum = np.abs(np.fft.rfft(y * np.hanning(y.size)))
    carrier_hz = float(np.fft.rfftfreq(y.size, 1 / rate_hz)[1 + int(np.argmax(spectrum[1:]))])
    if carrier_hz > 0.45 * rate_hz:
        raise must_be("recording: rate", rate_hz, f"above {carrier_hz / 0.45:.5g}, or 'envelope'", "Hz")
    size = max(round(4 * rate_hz / carrier_hz), 4)
    envelope = np.sqrt(2 * np.convolve(y**2, np.ones(size) / size, mode="same"))
    pieces, fits, late, falls = [], [], [], True
    for start, stop, falls in jumps_of(envelope, size):
        piece = y[start + size : stop]
        first = _ring(piece, rate_hz, carrier_hz, falls)
        constant = round(rate_hz * first[1] / (math.pi * first[0]))
        pieces.append(piece[: round(CONSTANTS * constant)])
        fits.append(_ring(pieces[-1], rate_hz, carrier_hz, falls))
        late.append(_ring(pieces[-1][constant:], rate_hz, carrier_hz, falls))
    values, errors, freedom, moved = _over(fits, late)
    misfit = float(np.median([fit[2] for fit in fits]))
    if misfit > WORST_MISFIT:
        raise must_be(f"recording: misfit of {values[0]:.5g} Hz", misfit, f"at most {WORST_MISFIT:g}")
    return PlateResonance(
        Estimate(values[0], errors[0], "Hz", freedom),
        Estimate(values[1], errors[1], "", freedom),
        moved[0],
        moved[1],
        misfit,
        f"{len(fits)} {'falls' if falls else 'rises'} of the vibration",
        np.arange(pieces[0].size) / rate_hz,
        pieces[0],
        fits[0][5],
    )


def _ring(piece: Array, rate_hz: float, carrier_hz: float, falls: bool) -> Ring:
    """Return resonance in Hz, Q, misfit, the errors of both, and the fitted curve."""
    time = np.arange(piece.size) / rate_hz
    width = carrier_hz / 100

    def shape(x: Array) -> Array:
        columns = damped(time, [(carrier_hz + width * x[0], math.exp(x[1]))])
        if falls:
            return columns
        angle = 2 * math.pi * (carrier_hz + width * x[2]) * time
        return np.column_stack([columns, np.cos(angle), np.sin(angle)])

    def fitted(x: Array) -> Array:
        columns = shape(x)
        weight = np.linalg.lstsq(columns.T @ columns, columns.T @ piece, rcond=1e-13)[0]
        return np.asarray(columns @ weight)

    near = 0.0
    if falls:
        spectrum = np.abs(np.fft.rfft(piece, 8 * piece.size))
        near = (float(np.fft.rfftfreq(8 * piece.size, 1 / rate_hz)[int(np.argmax(spectrum))]) - carrier_hz) / width
    starts = [[near, math.log(q), *([] if falls else [0.0])] for q in (50.0, 300.0)]
    tried = [least_squares(lambda x: fitted(x) - piece, start, x_scale=0.1) for start in starts]
    best = min(tried, key=lambda fit: float(fit.cost))
    errors = sandwich(best.jac, best.fun).standard
    q = math.exp(best.x[1])
    misfit = float(np.linalg.norm(best.fun) / max(float(np.linalg.norm(piece)), 1e-300))
    hertz = float(carrier_hz + width * best.x[0])
    return hertz, q, misfit, float(width * errors[0]), float(q * errors[1]), fitted(best.x)


def _over(fits: list[Ring], late: list[Ring]) -> tuple[list[float], list[float], float, list[float]]:
    """Return mean, standard error, degrees of freedom, and how far later fits move the mean, of resonance and Q."""
    both, other = (np.array([fit[:2] for fit in each]) for each in (fits, late))
    if len(fits) > 1:
        errors, freedom = both.std(axis=0, ddof=1) / math.sqrt(len(fits)), len(fits) - 1.0
    else:
        errors, freedom = np.array(fits[0][3:5]), math.inf
    moved = np.abs(other.mean(axis=0) - both.mean(axis=0)) / math.sqrt(3)
    return both.mean(axis=0).tolist(), errors.tolist(), freedom, moved.tolist()


class PlateEnvelope(NamedTuple):
    """How fast the amplitude follows, where only the amplitude was recorded."""

    corner: Estimate
    """Hz."""
    method_hz: float
    """Standard error in Hz from where the fit begins."""
    jumps: int
    misfit: float
    time_s: Array
    """The first jump, drawn."""
    y: Array
    fitted: Array


def plate_envelope(recording: xr.Dataset) -> PlateEnvelope:
    """Return the corner 1/(2 pi T) from the recorded amplitude, A(t) = A1 + (A0 - A1) e^(-t/T) after each jump.

    Parameters
    ----------
    recording : xarray.Dataset
        ``envelope`` in um, m/s or V over ``time`` in s: the amplitude, as a lock-in or a rectifier gives it.

    Raises
    ------
    FrictionloopError
        For a column that is missing, no jump, or a rise or fall that one time constant does not explain.
    """
    envelope, rate_hz = channel(recording, "envelope", VIBRATIONS), rate_of(recording)
    size = max(min(envelope.size // 2000, round(2e-4 * rate_hz)), 1)
    pieces, fits, late = [], [], []
    for start, stop, _ in jumps_of(envelope, size):
        piece = envelope[start + 1 : stop]
        constant = _exponential(piece, rate_hz)[0] * rate_hz
        pieces.append(piece[: max(round(CONSTANTS * constant), 12)])
        fits.append(_exponential(pieces[-1], rate_hz))
        late.append(_exponential(pieces[-1][round(constant / 2) :], rate_hz))
    times = np.array([fit[0] for fit in fits])
    misfit = float(np.median([fit[1] for fit in fits]))
    if misfit > WORST_MISFIT:
        raise must_be(f"recording: misfit of {1e3 * times.mean():.3g} ms", misfit, f"at most {WORST_MISFIT:g}")
    mean = float(times.mean())
    error = float(times.std(ddof=1)) / math.sqrt(times.size) if times.size > 1 else fits[0][2]
    freedom = times.size - 1.0 if times.size > 1 else max(pieces[0].size - 3.0, 1.0)
    corner = 1 / (2 * math.pi * mean)
    moved = abs(float(np.mean([fit[0] for fit in late])) - mean) / math.sqrt(3)
    return PlateEnvelope(
        Estimate(corner, corner * error / mean, "Hz", freedom), corner * moved / mean, times.size, misfit,
        np.arange(pieces[0].size) / rate_hz, pieces[0], fits[0][3],
    )  # fmt: skip


def _exponential(piece: Array, rate_hz: float) -> tuple[float, float, float, Array]:
    """Return the time constant in s, the misfit, the error of the time, and the fitted curve."""
    time = np.arange(piece.size) / rate_hz

    def fitted(x: Array) -> Array:
        columns = np.stack([np.ones_like(time), np.exp(-time / math.exp(x[0]))], axis=1)
        return np.asarray(columns @ np.linalg.lstsq(columns, piece, rcond=None)[0])

    ends = float(piece[0]), float(np.median(piece[-max(piece.size // 10, 1) :]))
    inner = np.flatnonzero(np.abs(piece - ends[1]) < abs(ends[0] - ends[1]) / math.e)
    guess = max(float(inner[0]) if inner.size else 1.0, 1.0) / rate_hz
    fit = least_squares(lambda x: fitted(x) - piece, [math.log(guess)], x_scale=0.1)
    constant = math.exp(fit.x[0])
    error = constant * float(sandwich(fit.jac, fit.fun).standard[0])
    return constant, float(np.linalg.norm(fit.fun) / np.linalg.norm(piece - ends[1])), error, fitted(fit.x)


def plate_entry(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor) -> EntryResult:
    """Return resonance, Q and corner of the envelope from stepped sines, decays or rises, or envelopes."""
    if all("envelope" in run for run in runs):
        return _envelope(runs)
    runs = [stepped(run) if "frequency" in run and "time" in run.dims else run for run in runs]
    found = [plate_sweep(run) if "frequency" in run else plate_decay(run) for run in runs]
    how = found[0].how + (f", {len(found)} recordings" if len(found) > 1 else "")
    hertz, q, corner = zip(*((f.method_hz, f.method_q, f.method_corner_hz) for f in found), strict=True)
    values = [
        measured("plate.frequency_hz", [f.resonance for f in found], hertz, how),
        measured("plate.q", [f.q for f in found], q, how),
        measured(CORNER, [f.corner for f in found], corner, how),
    ]
    drawn = "sweep" if "frequency" in runs[0] else "decay"
    numbers = {"misfit_percent": [100 * f.misfit for f in found]}
    curves = thinned(4 * POINTS, x=found[0].x, y=found[0].y, fitted=found[0].fitted)
    unit = runs[0]["vibration"].attrs["units"]
    return EntryResult(values, [], numbers, [], {drawn: {**curves, "unit": unit}})


def _envelope(runs: Sequence[xr.Dataset]) -> EntryResult:
    found = [plate_envelope(run) for run in runs]
    how = f"{sum(f.jumps for f in found)} jumps of the envelope"
    value = measured(CORNER, [f.corner for f in found], [f.method_hz for f in found], how)
    first = found[0]
    drawn = thinned(POINTS, x=first.time_s, y=first.y, fitted=first.fitted)
    curves = {**drawn, "unit": runs[0]["envelope"].attrs["units"]}
    return EntryResult([value], [], {"misfit_percent": [100 * f.misfit for f in found]}, [], {"envelope": curves})
