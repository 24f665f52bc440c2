"""Force to reading over frequency: H1 and coherence of a hammer's hits, a table, and one resonance fitted to either."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import least_squares

from frictionloop.findings import Condition, Finding
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.hit_onsets import without_bow
from frictionloop.identification.hits import hits_of, too_few
from frictionloop.identification.project_entry_result import Refused
from frictionloop.identification.recording_columns import READING, READING_UNITS, channel, rate_of
from frictionloop.identification.recording_file import Opened, Run
from frictionloop.quantities import Array, Complex, must_be


@dataclass(frozen=True)
class Resonance:
    """A suspension and a lag, fitted to a frequency response."""

    resonance: Estimate
    """Hz."""
    q: Estimate
    gain: Estimate
    """Reading per force below the resonance, negative if one is turned round; a hammer's own calibration is in it."""
    lag: Estimate
    """Time constant of the pole, in s."""
    band_hz: tuple[float, float]
    misfit: float
    """rms of the residual over that of the response, weighted as in the fit."""

    @property
    def cutoff_hz(self) -> float:
        """Cutoff of the pole, 1/(2 pi lag)."""
        return float(1 / (2 * np.pi * self.lag.value))


def fit_resonance(measured: FrequencyResponse, band_hz: tuple[float, float] | None = None) -> Resonance:
    """Return resonance, Q, gain and lag with their uncertainties.

        H(f) = G / (1 - (f/f0)^2 + j f/(f0 Q)) / (1 + j 2 pi f T)

    Least squares on H over the band, each frequency weighted by the power of the hammer there: that is the likelihood
    for noise of the reading which is white. The covariance is the sandwich (J^T J)^-1 J^T diag(r^2) J (J^T J)^-1 with
    leverages taken off (HC3), which also holds where the noise has the resonance in it, as that of a shaking base has.
    Resonance and Q rest on the few frequencies about the peak, and Student's distribution has as many degrees of
    freedom as those give.

    Parameters
    ----------
    measured : FrequencyResponse
        From `response`.
    band_hz : tuple, optional
        Lower and upper frequency in Hz; None is a fifth to two and a half times that of the largest response, cut at
        what the hammer excites (1 % of its power). At least eight frequencies.

    Raises
    ------
    FrictionloopError
        For a rate too low to show a resonance, a band that is empty or beyond half the rate, or a fit that fails.

    Notes
    -----
    Source: paper, Sec. 3.3 (the resonance); MacKinnon and White, J. Econometrics 29 (1985) 305, for HC3; Satterthwaite,
    Biometrics 2 (1946) 110, for the degrees of freedom.
    """
    low, high = _band(measured, band_hz)
    inside = (measured.frequency_hz >= low) & (measured.frequency_hz <= high)
    if np.count_nonzero(inside) < 8:
        raise must_be("band_hz", (low, high), "around 8 or more frequencies", "Hz")
    frequency, response = measured.frequency_hz[inside], measured.response[inside]
    weight = np.sqrt(measured.input_density[inside] / np.mean(measured.input_density[inside]))
    # A channel that is turned round has a negative gain.
    sign = -1.0 if float(np.sum((weight**2 * response).real[: max(response.size // 8, 4)])) < 0 else 1.0
    response = sign * response
    top = int(np.argmax(np.abs(response)))
    gain = float(np.median(np.abs(response[: max(top // 3, 1)])))

    def residuals(x: Array) -> Array:
        away = weight * (model(frequency, x) - response) / gain
        return np.concatenate([away.real, away.imag])

    # Logarithms keep gain, resonance and Q positive; the lag may come out as anything.
    guess = np.array([np.log(gain), np.log(frequency[top]), np.log(max(abs(response[top]) / gain, 0.6)), 1e-4])
    fit = least_squares(residuals, guess, x_scale=[1e-3, 1e-3, 1e-2, 1e-5], xtol=1e-14, ftol=1e-14, gtol=1e-14)
    found_hz = float(np.exp(fit.x[1]))
    if not (fit.success and low < found_hz < high):
        seen = {**measured.drawn(inside), "fitted": np.abs(model(frequency, fit.x)).tolist()}
        said = must_be("band_hz", (low, high), f"around {found_hz:.4g}", "Hz")
        raise Refused(str(said), "response", {"response": seen})
    errors = sandwich(fit.jac, fit.fun)
    scale = np.array([*np.exp(fit.x[:3]), 1.0])
    values = np.array([sign * np.exp(fit.x[0]), *np.exp(fit.x[1:3]), fit.x[3]])
    gain_, hertz, q, lag_ = errors.estimates(values, scale, (measured.unit, "Hz", "", "s"))
    misfit = float(np.linalg.norm(fit.fun) / np.linalg.norm(weight * np.abs(response) / gain))
    return Resonance(hertz, q, gain_, lag_, (low, high), misfit)


def model(frequency_hz: Array, x: Array) -> Complex:
    """Return H(f) for x = (log gain, log resonance in Hz, log Q, lag in s)."""
    relative = frequency_hz / np.exp(x[1])
    springs = np.exp(x[0]) / (1 - relative**2 + 1j * relative / np.exp(x[2]))
    return np.asarray(springs / (1 + 2j * np.pi * frequency_hz * x[3]))


class Errors(NamedTuple):
    """Standard errors of fitted parameters and the degrees of freedom behind each."""

    standard: Array
    freedom: Array

    def estimates(self, values: Array, scale: Array, units: Sequence[str]) -> list[Estimate]:
        """Return values with the errors times a scale, what a parameter's change does to its value."""
        rows = zip(values, scale * self.standard, units, self.freedom, strict=True)
        return [Estimate(float(value), float(error), unit, float(freedom)) for value, error, unit, freedom in rows]


def sandwich(jacobian: Array, residuals: Array) -> Errors:
    """Return the HC3 errors of least squares, for residuals that are independent but not equally large.

    A parameter's variance is a sum of c_i^2 r_i^2/(1 - h_i)^2 over residuals r_i with leverages h_i, so a weighted sum
    of squares of normals: it has 3 (sum)^2 / sum of squared terms degrees of freedom (Satterthwaite, with E r^4 =
    3 (E r^2)^2).
    """
    q, r = np.linalg.qr(jacobian)
    leverage = np.minimum(np.sum(q**2, axis=1), 0.99)
    terms = (np.linalg.solve(r, q.T) * (residuals / (1 - leverage))) ** 2
    variance = np.sum(terms, axis=1)
    most = float(residuals.size - jacobian.shape[1])
    squares = np.maximum(np.sum(terms**2, axis=1), 1e-300)
    return Errors(np.sqrt(variance), np.clip(3 * variance**2 / squares, 1.0, most))


def _band(measured: FrequencyResponse, band_hz: tuple[float, float] | None) -> tuple[float, float]:
    half_hz = measured.rate_hz / 2
    if band_hz is not None:
        low, high = (float(end) for end in band_hz)
        if not 0 < low < high <= half_hz:
            raise must_be("band_hz", (low, high), f"rising within 0 to {half_hz:g}", "Hz")
        return low, high
    excited = measured.input_density >= 0.01 * np.max(measured.input_density)
    upto = measured.frequency_hz[excited]
    peak_hz = float(upto[np.argmax(np.abs(measured.response[excited]))])
    if peak_hz > 0.8 * half_hz:
        raise must_be("recording: rate", measured.rate_hz, f"four times the resonance, above {peak_hz:g}", "Hz")
    return 0.2 * peak_hz, min(2.5 * peak_hz, float(upto[-1]))


UNKNOWN_SHARE = 0.01
"""Share of its size that a value of a table is taken to be off by where no coherence stands beside it (assumed)."""
LEAST = 8
"""Frequencies that a table must have."""
_NAMES = "frequency, and response or magnitude"


@dataclass(frozen=True)
class FrequencyResponse:
    """An estimate over frequency; all arrays have one shape."""

    frequency_hz: Array
    response: Complex
    """Reading over force, ``unit``."""
    coherence: Array
    """Share of the reading's power that follows from the force, 0 to 1."""
    relative_error: Array
    """Standard error of |response| over |response|, sqrt((1 - coherence)/(2 n coherence))."""
    input_density: Array
    """Power density of the force: how well each frequency was excited."""
    hits: int
    rate_hz: float
    unit: str
    findings: tuple[Finding, ...] = ()
    """Which channels are turned round."""

    def drawn(self, rows: Any = slice(None)) -> dict[str, list[float]]:
        """Return what is drawn of some of its rows."""
        curves = {"frequency_hz": self.frequency_hz, "magnitude": np.abs(self.response), "coherence": self.coherence}
        return {name: each[rows].tolist() for name, each in curves.items()}


def response(
    recording: Run | Sequence[Run], segment_s: float = 0.5, exclude: Collection[int] = ()
) -> FrequencyResponse:
    """Return force to reading over frequency and the coherence, averaged over the good hits of a hammer (`pick_hits`).

        H1 = S_xy/S_xx,   coherence = |S_xy|^2/(S_xx S_yy)

    The pieces are not tapered: force and response begin and end within them, so nothing leaks.
    Noise of the reading does not bias H1; noise of the hammer lowers it by its share of S_xx. H2, of which the opposite
    holds, is H1 over the coherence. A hammer that reads a push as negative is turned, and a recording whose reading
    goes the other way than most.

    Parameters
    ----------
    recording : xarray.Dataset or sequence of them
        Columns ``hammer`` in N and ``f_m`` in N, V or counts, over ``time`` in s; several at one rate are one
        measurement.
    segment_s : float
        Length of a piece in s; its inverse is the distance between frequencies. The response must have decayed.
    exclude : collection of int
        Numbers of hits to leave out, of one recording.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, or fewer than two good hits.

    Notes
    -----
    Source: Bendat and Piersol, Random Data, 4th ed., Sec. 9.2 for the standard error (ours: n hits, one segment each).
    """
    if isinstance(recording, xr.Dataset):
        channel(recording, "hammer", ("N",))  # hits are found without one, too; a response is not
    forces, readings, rates, picked, names, unit = [], [], [], [], [], ""
    doubts: list[Finding] = []
    for run, found in hits_of(recording, segment_s, exclude):
        force, reading = channel(run, "hammer", ("N",)), channel(run, READING, READING_UNITS)
        rows = np.array(found.starts, dtype=int)[:, None] + np.arange(found.length)
        forces.append((-force if found.inverted else force)[rows])
        readings.append(without_bow(reading)[0][rows])
        rates.append(rate_of(run))
        picked.append(found)
        names.append(os.path.basename(run.attrs.get("file", "")) or f"recording {len(picked)}")
        unit = f"{run[READING].attrs['units']}/N"
        if found.inverted:
            doubts.append(_turned_round(min(hit.peak for hit in found.table), "N", names[-1], "hammer"))
    if len(set(rates)) > 1:
        raise must_be("recording: rates", sorted(set(rates)), "one", "Hz")
    hits = sum(len(force) for force in forces)
    if hits < 2:
        raise too_few(picked, hits)
    rate_hz, length = rates[0], forces[0].shape[1]
    x, y = ([np.fft.rfft(each - each.mean(axis=1, keepdims=True)) for each in some] for some in (forces, readings))
    crossed = [force.conj() * reading for force, reading in zip(x, y, strict=True)]

    def density(parts: list[Any]) -> Any:
        return np.concatenate(parts).mean(axis=0) * 2 / (rate_hz * length)

    frequency = np.fft.rfftfreq(length, 1 / rate_hz)
    of_force, of_reading = (density([np.abs(each) ** 2 for each in some]) for some in (x, y))
    # Well below the largest reading it follows the force, whatever modes there are.
    upto = (frequency > 0) & (frequency <= 0.5 * frequency[np.argmax(of_reading)])
    signs = [float(np.sign(np.sum(each.real[:, upto]))) for each in crossed]
    other = -1.0 if sum(signs) >= 0 else 1.0
    across = density([-each if sign == other else each for each, sign in zip(crossed, signs, strict=True)])
    static = float(np.sum(across.real[upto]) / max(float(np.sum(of_force[upto])), 1e-300))
    doubts += [
        _turned_round(-abs(static), unit, name) for name, sign in zip(names, signs, strict=True) if sign == other
    ]
    doubts += [_turned_round(static, unit, "", "f_m or hammer")] if static < 0 else []
    keep = (frequency > 0) & (of_force > 0) & (of_reading > 0) & (np.abs(across) > 0)
    across, of_force = across[keep], of_force[keep]
    coherence = np.clip(np.abs(across) ** 2 / (of_force * of_reading[keep]), 1e-300, 1.0)
    return FrequencyResponse(
        frequency_hz=frequency[keep],
        response=across / of_force,
        coherence=coherence,
        relative_error=np.sqrt((1 - coherence) / (2 * hits * coherence)),
        input_density=of_force,
        hits=hits,
        rate_hz=rate_hz,
        unit=unit,
        findings=tuple(doubts),
    )


def _turned_round(low: float, unit: str, recording: str, channel: str = "") -> Finding:
    where = Condition(recording=recording, channel=channel)
    return Finding("SIGN-DOUBT", unit=unit, where=where, remedy="sign = -1", more={"low": low, "high": 0.0})


def response_table(file: Opened) -> FrequencyResponse:
    """Return the response that a file lists over frequency.

    Parameters
    ----------
    file : Opened
        Channels ``frequency`` in Hz, and ``response`` (complex), ``real`` and ``imaginary``, or ``magnitude`` and
        ``phase_deg`` or ``phase_rad``; a ``coherence`` is used if it is there. A magnitude in dB is 20 log10 of it.
        Rows of one frequency are averaged, and their order does not matter. Without a phase the response is real and
        its fit goes by magnitude.

    Raises
    ------
    FrictionloopError
        For columns that are missing, fewer than eight frequencies, or values that are no numbers.
    """
    columns = {name: np.asarray(line.samples[:]) for name, line in file.picked.items()}
    if "frequency" not in columns:
        raise must_be(f"{file.where}: channels", ", ".join(columns), _NAMES)
    sizes = {name: values.size for name, values in columns.items()}
    if len(set(sizes.values())) > 1:
        raise must_be(f"{file.where}: samples of columns", sizes, "equal")
    hertz = np.asarray(columns["frequency"], dtype=float)
    values = _complex(file, columns)
    coherence = np.asarray(columns.get("coherence", np.full(hertz.size, np.nan)), dtype=float)
    fine = np.isfinite(hertz) & np.isfinite(values) & (hertz > 0)
    steps, place = np.unique(hertz[fine], return_inverse=True)
    if steps.size < LEAST:
        raise must_be(f"{file.where}: frequencies", int(steps.size), f"at least {LEAST}")
    count = np.bincount(place)
    total = np.bincount(place, values[fine].real) + 1j * np.bincount(place, values[fine].imag)
    mean = (total / count).astype(complex)
    shared = np.bincount(place, np.nan_to_num(coherence[fine], nan=1 / (1 + 2 * UNKNOWN_SHARE**2))) / count
    shared = np.clip(shared, 1e-6, 1.0)
    # No rate is told: the highest frequency stands for half of one.
    told = file.picked["magnitude" if "magnitude" in columns else "frequency"].unit
    return FrequencyResponse(
        steps, mean, shared, np.sqrt((1 - shared) / (2 * shared)), np.ones_like(steps), int(count.max()),
        2 * float(steps[-1]), told if "magnitude" in columns and told else "1",
    )  # fmt: skip


def _complex(file: Opened, columns: dict[str, NDArray[np.generic]]) -> Complex:
    if "response" in columns:
        return columns["response"].astype(complex)
    if "real" in columns and "imaginary" in columns:
        return np.asarray(columns["real"], dtype=float) + 1j * np.asarray(columns["imaginary"], dtype=float)
    if "magnitude" not in columns:
        raise must_be(f"{file.where}: channels", ", ".join(columns), _NAMES)
    size = np.asarray(columns["magnitude"], dtype=float)
    line, told = file.picked["magnitude"], file.chart.channels["magnitude"]
    said = told.unit or line.unit or line.name.rpartition(" ")[2]
    if said.strip("[]() ").lower() == "db":
        size = 10 ** (size / 20)
    if np.nanmin(size) < 0:
        raise must_be(f"{file.where}: magnitude", float(np.nanmin(size)), "0 or more, or dB")
    turn = np.zeros_like(size)
    if "phase_deg" in columns:
        turn = np.deg2rad(np.asarray(columns["phase_deg"], dtype=float))
    elif "phase_rad" in columns:
        turn = np.asarray(columns["phase_rad"], dtype=float)
    return np.asarray((told.scale or 1.0) * size * np.exp(1j * turn))
