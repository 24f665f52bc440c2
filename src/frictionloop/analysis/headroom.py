"""What is left to gain: a loop's residual against the least that delay, sampling and Bode's integral allow."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictionloop.analysis.disturbance import touch_spectrum
from frictionloop.analysis.elements import linearise_contact
from frictionloop.analysis.limits import Lag, available_crossover_hz, bode_integral, phase_lag, stubborn, unstable_sum
from frictionloop.analysis.linear import LinearLoop, linearise
from frictionloop.analysis.state_space import Array
from frictionloop.analysis.waterbed import waterbed_bound
from frictionloop.parameters import FingerFriction, Strokes, System
from frictionloop.perception.thresholds import LOWEST_HZ as TOUCH_HZ

POINTS = 2500
LOWEST_HZ = 1e-3
"""Well below the drift of a load, whose period is some ten seconds."""


class Headroom(NamedTuple):
    """The loop at its mean force on a dry finger, and the best that any linear controller does there.

    Disturbance is what friction noise, tremor and drift of the load do to the force behind the contact, which passes
    them on with its lag. Nothing else is in it: feed-forward, not feedback, follows a set-point; occlusion is slower;
    and sensor noise, clamp, sticking and what a law makes of a measured load are for a simulation to show.
    """

    loop: LinearLoop
    frequency_hz: Array
    sensitivity: Array
    """|S|."""
    least: Array
    """|S| of the least residual (`waterbed_bound`); NaN without a finger that strokes."""
    disturbance_rms_n: float
    """What moves the force without control, N rms; NaN without a finger that strokes, as the next three."""
    disturbance_felt_rms_n: float
    """The part of it from 1 Hz on, where touch begins to count; the rest is drift, which any integral takes away."""
    residual_rms_n: float
    """What this loop leaves of it."""
    least_rms_n: float
    """What the best linear controller with the largest Ms asked for leaves."""
    zero_db_hz: float
    """Lowest frequency at which |S| is 1."""
    least_zero_db_hz: float
    """The same of the least residual."""
    delay_limit_hz: float
    """Highest crossover with 45 degrees of margin if all but delay and hold is inverted."""
    plain_limit_hz: float
    """The same if nothing is inverted."""
    lag: Lag
    """Phase lag at the zero-dB frequency of this loop (of the least residual if it has none), by cause."""
    bode_integral: float
    """Mean of ln|S|; `unstable_sum` says what it must be."""
    unstable_sum: float
    delay_periods: int
    """Periods from a force to the first that answers to it."""


def headroom(system: System, sensitivity_peak: float) -> Headroom:
    """Return what a System's controller leaves, and what any linear one must leave with so large an Ms.

    Parameters
    ----------
    system
        The loop.
    sensitivity_peak
        Largest |S| that the bound may use, above 1.

    Raises
    ------
    FrictionloopError
        The law has no linear analysis at the mean force.
    """
    loop = linearise(system)
    frequency = np.geomspace(LOWEST_HZ, loop.nyquist_hz, POINTS)
    S, fixed = np.abs(loop.responses(frequency)["S"]), stubborn(loop)
    least, rms, zero_db = np.full(POINTS, math.nan), (math.nan,) * 4, math.nan
    if isinstance(system.friction, FingerFriction) and isinstance(system.motion, Strokes):
        lag = np.abs(linearise_contact(system, loop.elements.force_n).response(frequency))
        power = touch_spectrum(system, 0.0)(frequency) * lag**2
        given = {"delay_periods": fixed.delay_periods, "zeros": fixed.zeros.tolist()}
        bound = waterbed_bound(frequency, power, sensitivity_peak, loop.nyquist_hz, **given)
        least, zero_db = bound.sensitivity, bound.zero_db_hz
        whole, felt, left = (
            _rms_n(frequency, each, loop) for each in (power, power * (frequency >= TOUCH_HZ), power * S**2)
        )
        rms = whole, felt, left, bound.residual_rms_n
    own_hz = _zero_db_hz(frequency, S)
    at_hz = next((hz for hz in (own_hz, zero_db) if math.isfinite(hz)), 0.1 * loop.nyquist_hz)
    return Headroom(
        loop, frequency, S, least, *rms, own_hz, zero_db,
        available_crossover_hz(loop), available_crossover_hz(loop, inverted=False), phase_lag(loop, at_hz),
        bode_integral(loop), unstable_sum(loop), fixed.delay_periods,
    )  # fmt: skip


def _rms_n(frequency: Array, power: Array, loop: LinearLoop) -> float:
    """Return the rms of a density, each frequency standing for its band as in `waterbed_bound`."""
    edges = np.concatenate([[0.0], (frequency[1:] + frequency[:-1]) / 2, [loop.nyquist_hz]])
    return math.sqrt(float(np.diff(edges) @ power))


def _zero_db_hz(frequency: Array, S: Array) -> float:
    """Return where |S| first is 1, NaN if it never is or already at the lowest frequency."""
    above = np.flatnonzero(S >= 1.0)
    return float(frequency[above[0]]) if above.size and above[0] > 0 else math.nan
