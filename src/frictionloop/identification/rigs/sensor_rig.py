"""The sensor's simulated rigs: what a recorder writes of a quiet minute, and of an impact hammer.

    x1'' + (w/Q) x1' + w^2 x1 = w^2 (F + m a),   x3' = wc (x1 + n - x3),   a' = wb (v - a)

x1 is the force of the springs, x3 the reading, a the acceleration of the base, n and v white. Sampling is exact: the
step over 1/rate by the matrix exponential, and noise whose covariance is that of the equations, at any rate.

The sensor left alone is rig (c) (paper, Sec. 3.3 and Fig. 4b).
"""

from __future__ import annotations

import json
import math
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.constants import g as STANDARD_GRAVITY
from scipy.linalg import expm, solve_continuous_lyapunov
from scipy.signal import lfilter

from frictionloop.loop.simulate import check_seed
from frictionloop.parameters import SCHEMA, SuspendedSensor
from frictionloop.parameters.calibration_bench import CalibrationBench
from frictionloop.quantities import Array, must_be
from frictionloop.quantities.code_version import package_version
from frictionloop.quantities.counter_noise import covariance_root, normals
from frictionloop.quantities.value_checks import number, whole
from frictionloop.sensing.force_sensor import converter

LEAST_RATE = 4.0
"""Samples per period of the resonance that the rig asks for."""


def hammer_rig(
    bench: CalibrationBench | None = None,
    hits: int = 10,
    peak_n: float = 0.5,
    pulse_s: float = 3e-3,
    interval_s: float = 1.0,
    rate_hz: float = 5000.0,
    seed: int = 0,
) -> xr.Dataset:
    """Return the recording of some hits: ``hammer`` and ``f_m``, both in N, over ``time`` in s.

    A hit is half a sine, F(t) = A sin(pi t/T) for 0 < t < T, at a fifth of every interval and up to a tenth later. Its
    spectrum falls to nothing at 1.5/T (500 Hz for 3 ms), which bounds the frequencies that can be analysed. The
    response of springs and pole is exact (closed form); noise, base and converter as in `sensor_rig`.

    Parameters
    ----------
    bench : CalibrationBench, optional
        Sensor and imperfections; None is the default bench. ``sensor.q`` must be above 0.5.
    hits : int
        Number of hits, at least 1; coherence needs two.
    peak_n : float
        Median of the peaks A in N, positive. A hit of 1 N and 3 ms rings to 1.7 N at 145 Hz; the harder the hit, the
        more ``errors.nonlinearity`` shows in gain and Q.
    pulse_s : float
        Median of the durations T in s, positive.
    interval_s : float
        Time from hit to hit in s, more than twice ``pulse_s``.
    rate_hz : float
        Samples per second: the controller's, or those of a faster recorder; at least 4 per period of the resonance.
    seed : int
        Seed of peaks, durations, times and noise.

    Raises
    ------
    FrictionloopError
        For a rate too low for the resonance, a pulse longer than the record, a reading beyond the sensor's range, or a
        number out of range.

    Notes
    -----
    Source: paper, Sec. 3.3; the imperfections are assumed (parameters/calibration_bench.py).
    """
    bench = bench or CalibrationBench()
    sensor = bench.sensor
    if sensor.q <= 0.5:
        raise must_be("sensor.q", sensor.q, "above 0.5")
    least_hz = LEAST_RATE * sensor.resonance_hz
    rate_hz = number("rate_hz", rate_hz, "Hz", least_hz, why=f" for sensor.resonance_hz = {sensor.resonance_hz:g} Hz")
    hits = whole("hits", hits, 1, 10**6)
    peak_n = number("peak_n", peak_n, "N", 1e-9)
    interval_s = number("interval_s", interval_s, "s", 2 / rate_hz)
    pulse_s = number("pulse_s", pulse_s, "s", 1 / rate_hz, interval_s / 2, f" (interval_s = {interval_s:g} s)")
    seed = check_seed(seed)
    z = normals(seed, OWN_STREAM, 0, 3 * hits).reshape(3, hits)
    peaks = peak_n * np.exp(bench.hammer.peak_spread * z[0])
    durations = pulse_s * np.exp(bench.hammer.width_spread * z[1])
    late = 0.1 * (z[2] - np.floor(z[2]))
    starts = interval_s * (np.arange(hits) + 0.2 + late)
    time = np.arange(round(hits * interval_s * rate_hz)) / rate_hz
    force_n, read_n = np.zeros_like(time), np.zeros_like(time)
    for start, peak, duration in zip(starts, peaks, durations, strict=True):
        force_n += peak * half_sine(time - start, duration)
        read_n += peak * half_sine_response(sensor, time - start, duration)
    _refuse_overload(read_n, peak_n, bench)
    noise = bench.hammer.noise_n * normals(seed, OWN_STREAM + 1, 0, time.size)
    channels = {
        "hammer": (1 + bench.hammer.gain_error) * force_n + noise,
        "f_m": reading(bench, read_n + spring_noise(bench, time.size, rate_hz, seed)),
    }
    return to_dataset(bench, "hammer", seed, rate_hz, channels)


def half_sine(time_s: Array, duration_s: float) -> Array:
    """Return sin(pi t/T) between 0 and T, 0 elsewhere."""
    inside = (time_s > 0) & (time_s < duration_s)
    return np.where(inside, np.sin(np.pi * np.clip(time_s / duration_s, 0, 1)), 0.0)


def half_sine_response(sensor: SuspendedSensor, time_s: Array, duration_s: float) -> Array:
    """Return the force behind the pole in N for a hit of 1 N that begins at t = 0, at times of any shape.

    Half a sine is a sine that begins at 0 and another that begins at T. The response to the first is the sum over the
    poles p of S(s) W/(s^2 + W^2), W = pi/T, of residue times e^(p t): two of the springs, one of the electronics, two
    of the sine; they differ from each other for any Q above 0.5.
    """
    omega, pole, drive = 2 * np.pi * sensor.resonance_hz, 2 * np.pi * sensor.cutoff_hz, np.pi / duration_s
    damping = omega / (2 * sensor.q)
    ringing = complex(-damping, math.sqrt(omega**2 - damping**2))
    poles = np.array([ringing, ringing.conjugate(), -pole, 1j * drive, -1j * drive])
    others = poles[:, None] - poles + np.eye(poles.size)
    residues = omega**2 * pole * drive / np.prod(others, axis=1)

    def begun(time: Array) -> Array:
        since = np.maximum(time, 0.0)
        total = sum(residue * np.exp(each * since) for residue, each in zip(residues, poles, strict=True))
        return np.where(time > 0, np.real(total), 0.0)

    return begun(time_s) + begun(time_s - duration_s)


def _refuse_overload(read_n: Array, peak_n: float, bench: CalibrationBench) -> None:
    errors, range_n = bench.errors, bench.sensor.range_n
    room_n = (range_n - abs(errors.offset_n)) / ((1 + errors.gain_error) * (1 + max(errors.nonlinearity, 0)))
    largest = float(np.max(np.abs(read_n)))
    if largest > room_n:
        most = math.floor(1e3 * max(peak_n * room_n / largest, 0)) / 1e3
        raise must_be("peak_n", peak_n, f"within sensor.range_n, at most {most:g}", "N")


STATES = 4
NOISE_STREAM = 0
"""Streams 0 to 3 drive the four states; the rigs draw their own from ``OWN_STREAM`` on."""
OWN_STREAM = 8
_VARIABLES = {"mass": ("kg", "mass as marked"), "hammer": ("N", "force of the hammer"), "f_m": ("N", "measured force")}
_SECONDS = 36000.0  # ten hours: what fits in memory at 5 kHz


class Rates(NamedTuple):
    """x' = drift x + force F + white noises: the columns of ``noise`` times unit white noise of two-sided density 1."""

    drift: Array
    force: Array
    noise: Array


def rates(bench: CalibrationBench) -> Rates:
    """Return the equations of the sensor for x = (x1, x1'/w, x3, m a), forces in N, time in s."""
    sensor = bench.sensor
    omega, pole = 2 * math.pi * sensor.resonance_hz, 2 * math.pi * sensor.cutoff_hz
    turn = 2 * math.pi * bench.base.corner_hz
    shaking_n = sensor.moving_mass_kg * bench.base.vibration_ug * 1e-6 * STANDARD_GRAVITY
    drift = np.array(
        [[0, omega, 0, 0], [-omega, -omega / sensor.q, 0, omega], [pole, 0, -pole, 0], [0, 0, 0, -turn]], dtype=float
    )
    noise = np.zeros((STATES, 2))
    # A one-sided density S is a two-sided S/2; an rms r behind a first-order corner needs 2 wb r^2.
    noise[2, 0] = pole * sensor.noise_density_n_rthz / math.sqrt(2)
    noise[3, 1] = math.sqrt(2 * turn) * shaking_n
    return Rates(drift, np.array([0, omega, 0, 0], dtype=float), noise)


def covariance(bench: CalibrationBench) -> Array:
    """Return the covariance of the sensor's states at rest in N^2, shape (4, 4): P of D P + P D^T + B B^T = 0."""
    equations = rates(bench)
    return np.asarray(solve_continuous_lyapunov(equations.drift, -equations.noise @ equations.noise.T))


def spring_noise(bench: CalibrationBench, samples: int, rate_hz: float, seed: int) -> Array:
    """Return the noise of x3 in N at t_k = k / rate_hz, stationary from the first sample, shape (samples,)."""
    at_rest = covariance(bench)
    step = expm(rates(bench).drift / rate_hz)
    driven = covariance_root(at_rest - step @ at_rest @ step.T)
    white = np.stack([normals(seed, NOISE_STREAM + k, 0, samples) for k in range(STATES)])
    kicks = driven @ white
    kicks[:, 0] = covariance_root(at_rest) @ white[:, 0]
    return _accumulated(step, kicks)


def held_response(bench: CalibrationBench, force_n: Array, rate_hz: float) -> Array:
    """Return x3 in N for forces that are held from t_k to t_(k+1); at t_0 the sensor has settled on the first."""
    equations = rates(bench)
    step = expm(equations.drift / rate_hz)
    # With x settled on F, x = D^-1 (-f F); over a step of held force x gains (1 - E) times that.
    settled = np.linalg.solve(equations.drift, -equations.force)
    kicks = np.outer(settled - step @ settled, np.concatenate([[0.0], force_n[:-1]]))
    kicks[:, 0] = settled * force_n[0]
    return _accumulated(step, kicks)


def reading(bench: CalibrationBench, force_n: Array) -> Array:
    """Return what the converter gives for forces x3 behind the pole: gain, offset and curvature, then its steps."""
    errors, adc = bench.errors, converter(bench.sensor)
    curved = force_n * (1 + errors.nonlinearity * (force_n / bench.sensor.range_n) ** 2)
    given = errors.offset_n + (1 + errors.gain_error) * curved
    return np.clip(np.rint(given * adc.per_step) * adc.step_n, -adc.range_n, adc.range_n)


def to_dataset(bench: CalibrationBench, rig: str, seed: int, rate_hz: float, channels: dict[str, Array]) -> xr.Dataset:
    """Return the Dataset of a rig, row k holding the samples at t_k, with what repeats it in its attributes."""
    samples = len(next(iter(channels.values())))
    data = {
        name: xr.Variable("time", values, dict(zip(("units", "long_name"), _VARIABLES[name], strict=True)))
        for name, values in channels.items()
    }
    time = xr.Variable("time", np.arange(samples) / rate_hz, {"units": "s", "long_name": "time"})
    attributes: dict[str, Any] = {
        "rig": rig,
        "bench": json.dumps(bench.model_dump()),
        "version": package_version(),
        "schema": SCHEMA,
        "source": "simulated",
        "seed": seed,
    }
    return xr.Dataset(data, {"time": time}, attributes)


def _accumulated(step: Array, kicks: Array) -> Array:
    """Return the third state of x_k = step x_(k-1) + kick_k, x_0 = kick_0, for kicks of shape (states, samples).

    In the z domain x = (1 - step/z)^-1 kick; Faddeev and LeVerrier's recursion gives the polynomials of the inverse.
    """
    below = np.poly(step)
    above = [np.eye(STATES)]
    for coefficient in below[1:-1]:
        above.append(step @ above[-1] + coefficient * np.eye(STATES))
    return np.asarray(sum(lfilter([matrix[2, i] for matrix in above], below, kicks[i]) for i in range(STATES)))


def floor_rig(
    bench: CalibrationBench | None = None, duration_s: float = 10.0, rate_hz: float = 5000.0, seed: int = 0
) -> xr.Dataset:
    """Return the recording of the sensor without a finger: ``f_m`` in N over ``time`` in s.

    White noise of the electronics behind the pole, acceleration of the base times the moving mass through the
    suspension, offset and converter, all stationary from the first sample.

    Parameters
    ----------
    bench : CalibrationBench, optional
        Sensor and base; None is the default bench.
    duration_s : float
        Length in s; 10 in the paper.
    rate_hz : float
        Samples per second; what lies above half of it folds down, as it does without an anti-alias filter.
    seed : int
        Seed of the noise.

    Raises
    ------
    FrictionloopError
        For a number out of range.

    Notes
    -----
    Source: paper, Sec. 3.3.
    """
    bench = bench or CalibrationBench()
    rate_hz = number("rate_hz", rate_hz, "Hz", 1.0)
    duration_s = number("duration_s", duration_s, "s", 2 / rate_hz, _SECONDS)
    seed = check_seed(seed)
    noise_n = spring_noise(bench, round(duration_s * rate_hz), rate_hz, seed)
    return to_dataset(bench, "floor", seed, rate_hz, {"f_m": reading(bench, noise_n)})
