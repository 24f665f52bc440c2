"""Rig (a): standard weights pull the frame by a string over a pulley (paper, Sec. 3.3 and Fig. 4a).

What a pulley leaves of a weight: friction that acts against the motion, so that what arrives depends on the way.

With tension T1 of the weight and T2 at the frame, bearing friction mu at the radius r of the axle and the string at
radius R, a pulley that is just about to turn has (torque = mu r times the load of both tensions at the wrap angle)

    T1/T2 = e^(+-b),   sinh(b/2) = sin(wrap/2) e / sqrt(1 - e^2),   e = mu r / R.

A string that slides over a pulley that does not turn has b = mu_s wrap (Euler and Eytelwein). The easier one happens.
In between, T2 stays where it was: the play operator of hysteresis.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import accumulate

import numpy as np
import xarray as xr
from scipy.special import ndtr

from frictionloop.identification.rigs.sensor_rig import (
    OWN_STREAM,
    held_response,
    reading,
    spring_noise,
    to_dataset,
)
from frictionloop.loop.simulate import check_seed
from frictionloop.parameters.calibration_bench import CalibrationBench, Pulley
from frictionloop.quantities import Array, must_be
from frictionloop.quantities.counter_noise import normals
from frictionloop.quantities.value_checks import number

STEPS_UP = tuple(round(0.025 * k, 3) for k in range(11))
UP_AND_DOWN_KG = (*STEPS_UP, *STEPS_UP[-2::-1])
"""0 to 250 g, 2.45 N, and back in steps of 25 g (assumed; Fig. 4a goes to about 2.5 N)."""
_LEAST_RATE_HZ = 20.0  # ten samples in the time it takes to put a weight on, and in a period of the swing


def friction_exponent(pulley: Pulley) -> float:
    """Return b, the logarithm of the largest ratio of the two tensions, without the drag."""
    wrap = math.radians(pulley.wrap_deg)
    sliding = pulley.string_friction * wrap
    lever = pulley.bearing_friction * pulley.axle_radius_mm / pulley.radius_mm
    if lever >= 1:
        return sliding
    turning = 2 * math.asinh(abs(math.sin(wrap / 2)) * lever / math.sqrt(1 - lever**2))
    return min(turning, sliding)


def string_friction_for(exponent: float, wrap_deg: float = 90.0) -> float:
    """Return the friction of string on a peg that does not turn which gives b = ``exponent``."""
    return exponent / math.radians(wrap_deg)


def bearing_friction_for(exponent: float, pulley: Pulley) -> float:
    """Return the friction of the bearing of a pulley like ``pulley`` which gives b = ``exponent``; the string holds."""
    ratio = math.sinh(exponent / 2) / abs(math.sin(math.radians(pulley.wrap_deg) / 2))
    return ratio / math.sqrt(1 + ratio**2) * pulley.radius_mm / pulley.axle_radius_mm


def pulled(weight_n: Array, pulley: Pulley) -> Array:
    """Return T2 in N over time for tensions T1 >= 0, shape (samples,); at first both are equal.

    T2 = min(max(T2 before, e^-b T1 - d), e^b T1 + d), never below zero, d the drag.
    """
    exponent = friction_exponent(pulley)
    low = np.maximum(math.exp(-exponent) * weight_n - pulley.drag_n, 0.0).tolist()
    high = (math.exp(exponent) * weight_n + pulley.drag_n).tolist()

    def play(before: float, band: tuple[float, float]) -> float:
        return min(max(before, band[0]), band[1])

    following = accumulate(zip(low[1:], high[1:], strict=True), play, initial=float(weight_n[0]))
    return np.fromiter(following, float, len(low))


def weights_rig(
    masses_kg: Sequence[float] = UP_AND_DOWN_KG,
    bench: CalibrationBench | None = None,
    dwell_s: float = 4.0,
    rate_hz: float = 5000.0,
    seed: int = 0,
) -> xr.Dataset:
    """Return the recording of a calibration with weights: ``mass`` in kg as marked, ``f_m`` in N over ``time`` in s.

    Each mass m hangs for ``dwell_s``. Its pull grows smoothly to m (1 + error) g within ``weights.placing_s`` while the
    hook begins to swing by phi(t) = phi0 e^(-t/T) cos(w t), w = sqrt(g/L), which changes the tension by
    (phi0^2/4 - 3/4 phi0^2 cos 2wt) e^(-2t/T) of itself (second order in phi). What the pulley leaves of it
    (`pulled`) pulls the sensor (`sensor_rig`). The error of a mass is uniform within ``weights.tolerance``, the same
    whenever that mass hangs. Not in it: bounce of the string, stretch, temperature, the weight of the hook (a tare).

    Parameters
    ----------
    masses_kg : sequence of float
        Masses in the order they hang, not negative, at least two; up and down shows hysteresis.
    bench : CalibrationBench, optional
        Sensor and imperfections; None is the default bench.
    dwell_s : float
        Time each mass hangs in s, longer than ``weights.placing_s``.
    rate_hz : float
        Samples per second, at least 20.
    seed : int
        Seed of weights' errors and noise.

    Raises
    ------
    FrictionloopError
        For no masses, a negative one, one that pulls beyond the sensor's range, or a number out of range.

    Notes
    -----
    Source: paper, Sec. 3.3; the imperfections are assumed (parameters/calibration_bench.py).
    """
    bench = bench or CalibrationBench()
    masses = _masses(masses_kg, bench)
    rate_hz = number("rate_hz", rate_hz, "Hz", _LEAST_RATE_HZ)
    dwell_s = number("dwell_s", dwell_s, "s", bench.weights.placing_s, why=" (weights.placing_s)")
    seed = check_seed(seed)
    each = round(dwell_s * rate_hz)
    _, which = np.unique(masses, return_inverse=True)
    uniform = 2 * ndtr(normals(seed, OWN_STREAM, 0, int(which.max()) + 1)) - 1
    weight_n = _tension(masses * (1 + bench.weights.tolerance * uniform[which]), each, rate_hz, bench)
    read_n = held_response(bench, pulled(weight_n, bench.pulley), rate_hz)
    read_n += spring_noise(bench, read_n.size, rate_hz, seed)
    channels = {"mass": np.repeat(masses, each), "f_m": reading(bench, read_n)}
    return to_dataset(bench, "weights", seed, rate_hz, channels)


def _masses(masses_kg: Sequence[float], bench: CalibrationBench) -> Array:
    try:
        masses = np.asarray(masses_kg, dtype=float).reshape(-1)
    except (TypeError, ValueError):
        raise must_be("masses_kg", masses_kg, "a list of numbers", "kg") from None
    if masses.size < 2:
        raise must_be("masses_kg: masses", int(masses.size), "2 or more")
    errors, pulley = bench.errors, bench.pulley
    # What the reading may become: friction of the pulley that pulls along, gain and offset. The swing has decayed.
    share = math.exp(friction_exponent(pulley)) * bench.weights.gravity_m_s2 * (1 + bench.weights.tolerance)
    room_n = (bench.sensor.range_n - errors.offset_n) / ((1 + errors.gain_error) * (1 + max(errors.nonlinearity, 0)))
    most = max(room_n - pulley.drag_n, 0.0) / share
    for mass in masses[~(np.isfinite(masses) & (masses >= 0) & (masses <= most))][:1]:
        raise must_be("masses_kg", float(mass), f"0 to {math.floor(most * 1e4) / 1e4:g}, for sensor.range_n", "kg")
    return masses


def _tension(masses: Array, each: int, rate_hz: float, bench: CalibrationBench) -> Array:
    """Return T1 in N over time, shape (masses * each,)."""
    weights = bench.weights
    time = np.arange(each) / rate_hz
    eased = np.minimum(time / weights.placing_s, 1.0)
    eased = eased**2 * (3 - 2 * eased)  # no jump of the force nor of its rate
    angle = math.radians(weights.swing_deg) * np.exp(-time / weights.swing_decay_s)
    turn = math.sqrt(weights.gravity_m_s2 / weights.string_m)
    swing = angle**2 * (1 - 3 * np.cos(2 * turn * time)) / 4 * eased
    before = np.concatenate([masses[:1], masses[:-1]])
    hanging = before[:, None] + (masses - before)[:, None] * eased
    # Nobody has touched the hook before the first change.
    moved = np.concatenate([[0.0], np.ones(masses.size - 1)])[:, None]
    return np.asarray((hanging * (1 + moved * swing)).ravel() * weights.gravity_m_s2)
