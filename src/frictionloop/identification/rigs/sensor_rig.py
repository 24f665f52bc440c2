"""The sensor on a calibration rig: what it reads of a force, with its noise, the shaking base and its converter.

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
from numpy.typing import NDArray
from scipy.constants import g as STANDARD_GRAVITY
from scipy.linalg import eigh, expm, solve_continuous_lyapunov
from scipy.signal import lfilter

from frictionloop.loop.simulate import check_seed
from frictionloop.parameters import SCHEMA
from frictionloop.parameters.calibration_bench import CalibrationBench
from frictionloop.quantities.checks import number
from frictionloop.quantities.normals import normals
from frictionloop.quantities.version import package_version
from frictionloop.sensing.force_sensor import converter

Array = NDArray[np.float64]
STATES = 4
NOISE_STREAM = 0
"""Streams 0 to 3 drive the four states; the rigs draw their own from ``OWN_STREAM`` on."""
OWN_STREAM = 8
_VARIABLES = {
    "mass": ("kg", "mass as marked"),
    "hammer": ("N", "force of the hammer"),
    "f_m": ("N", "measured force"),
}
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
    driven = _root(at_rest - step @ at_rest @ step.T)
    white = np.stack([normals(seed, NOISE_STREAM + k, 0, samples) for k in range(STATES)])
    kicks = driven @ white
    kicks[:, 0] = _root(at_rest) @ white[:, 0]
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


def _root(symmetric: Array) -> Array:
    """Return R with R R^T = symmetric, whose eigenvalues may be zero or, by rounding, just below."""
    powers, directions = eigh(symmetric)
    return np.asarray(directions * np.sqrt(np.maximum(powers, 0)))


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
