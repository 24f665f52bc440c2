"""Rig (b): an impact hammer hits the frame (paper, Sec. 3.3 and Fig. 4b)."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.identification.rigs.sensor_rig import OWN_STREAM, reading, spring_noise, to_dataset
from frictionloop.loop.simulate import check_seed
from frictionloop.parameters import SuspendedSensor
from frictionloop.parameters.calibration_bench import CalibrationBench
from frictionloop.quantities import must_be
from frictionloop.quantities.checks import number, whole
from frictionloop.quantities.normals import normals

Array = NDArray[np.float64]
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
