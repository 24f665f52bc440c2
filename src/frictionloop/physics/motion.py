"""How the finger moves and presses: strokes and load in closed form of time, so that nothing drifts."""

from __future__ import annotations

import math
from typing import NamedTuple

from scipy.special import ndtr

from frictionloop.parameters.motion import TURN_SHARE, Strokes
from frictionloop.parameters.plant import RigidFinger, Skin
from frictionloop.quantities.counter_noise import normals
from frictionloop.quantities.scalar_math import ROUND, fma, sin_turns, step

DRIFT_STREAM = 18
"""Stream of the counter-based noise that the phases of the load's drift are drawn from."""
_GOLDEN = (1.0 + math.sqrt(5.0)) / 2.0


class StrokePlan(NamedTuple):
    """Coefficients of `stroke_step`."""

    turns_per_s: float
    """Cycles per second."""
    phase: float
    """Cycles at t = 0, counted from the middle of the stroke to the right."""
    cycle_s: float
    quarter_s: float
    per_half_reversal: float
    """2 / reversal_s, in 1/s."""
    half_plateau_s: float
    speed_m_s: float
    half_stroke_m: float
    turn_m: float
    """Distance covered at full speed in half a reversal."""


class LoadPlan(NamedTuple):
    """Coefficients of `load_step`."""

    turns_per_s: float
    """Landings per second."""
    phase: float
    """Cycles at t = 0, counted from the middle of the contact."""
    cycle_s: float
    half_contact_s: float
    per_landing: float
    """1 / landing_s, in 1/s."""
    load_n: float
    drift_n: float
    """Amplitude of each of the drift's two sines."""
    fast_hz: float
    fast_phase: float
    slow_hz: float
    slow_phase: float


@step
def turns_from_nearest(t: float, turns_per_s: float, phase: float) -> float:
    """t f + p less the nearest whole number, in [-1/2, 1/2]."""
    turns = fma(t, turns_per_s, phase)
    return turns - ((turns + ROUND) - ROUND)


@step
def stroke_step(t: float, plan: StrokePlan) -> tuple[float, float]:
    """x(t) in m and x'(t) in m/s: plateaus of constant speed, and reversals v (3 z - z^3)/2, z from 1 to -1 in time.

    Speed and acceleration are continuous. With z = 1 on the plateau and R the reversal's duration, the distance left to
    the end of the stroke is v R/2 (3 z^2/4 - z^4/8), plus v times the time left on the plateau.
    """
    turns_per_s, phase, cycle_s, quarter_s, per_half_reversal, half_plateau_s, speed, half_stroke, turn = plan
    turns = turns_from_nearest(t, turns_per_s, phase)
    away = abs(turns)
    since_middle = min(away, 0.5 - away) * cycle_s
    z = min((quarter_s - since_middle) * per_half_reversal, 1.0)
    z2 = z * z
    left = fma(turn * z2, fma(-0.125, z2, 0.75), speed * max(half_plateau_s - since_middle, 0.0))
    position = half_stroke - left
    velocity = speed * z * fma(-0.5, z2, 1.5)
    return (-position if turns < 0.0 else position), (-velocity if away > 0.25 else velocity)


@step
def load_step(t: float, tremor_n: float, plan: LoadPlan) -> float:
    """N(t) = max(c(t) (N + drift(t) + tremor), 0) in N, and exactly 0 between lift-off and landing.

    c rises from 0 to 1 as 3 y^2 - 2 y^3 while the finger lands and falls likewise before it has lifted. The drift is
    the sum of two sines whose frequencies are in the golden ratio, so that it does not repeat.
    """
    turns_per_s, phase, cycle_s, half_contact_s, per_landing, load, drift, fast, fast_phase, slow, slow_phase = plan
    from_middle = abs(turns_from_nearest(t, turns_per_s, phase)) * cycle_s
    y = min(max((half_contact_s - from_middle) * per_landing, 0.0), 1.0)
    contact = y * y * fma(-2.0, y, 3.0)
    sines = sin_turns(fma(t, fast, fast_phase)) + sin_turns(fma(t, slow, slow_phase))
    return max(contact * (fma(drift, sines, load) + tremor_n), 0.0)


def stroke_plan(motion: Strokes) -> StrokePlan:
    """Return the coefficients of `stroke_step`: positions are from the middle of the stroke, in m."""
    speed_m_s = 1e-3 * motion.speed_mm_s
    return StrokePlan(
        turns_per_s=1.0 / motion.cycle_s,
        phase=motion.start - 0.25,
        cycle_s=motion.cycle_s,
        quarter_s=0.25 * motion.cycle_s,
        per_half_reversal=2.0 / motion.reversal_s,
        half_plateau_s=0.5 * motion.plateau_s,
        speed_m_s=speed_m_s,
        half_stroke_m=0.5 * speed_m_s * (motion.plateau_s + TURN_SHARE * motion.reversal_s),
        turn_m=0.5 * speed_m_s * motion.reversal_s,
    )


def scored_edge_m(motion: Strokes, finger: RigidFinger | Skin) -> float:
    """Return how far from the middle of the stroke metrics count: half of it less twice F/k, in m.

    A reversal has to stretch the skin from -F/k to F/k, F being ``motion.unscored_n``, before any law can have the
    friction it wants; a soft skin takes more of the stroke for that. A rigid finger is given that of a `Skin`.
    What the contact itself yields, a twentieth of a `Skin`'s way, is not in it.
    """
    skin = finger if isinstance(finger, Skin) else Skin()
    return stroke_plan(motion).half_stroke_m - 2.0 * motion.unscored_n / skin.stiffness_n_m


def load_plan(motion: Strokes, seed: int) -> LoadPlan:
    """Return the coefficients of `load_step`; the seed decides the phases of the drift."""
    fast_phase, slow_phase = ndtr(normals(seed, DRIFT_STREAM, 0, 2)).tolist()
    # Two sines of this amplitude have the standard deviation asked for.
    drift = {
        "load_n": motion.load_n,
        "drift_n": motion.load_drift * motion.load_n,
        "fast_hz": 1.0 / motion.load_drift_s,
        "fast_phase": fast_phase,
        "slow_hz": 1.0 / (_GOLDEN * motion.load_drift_s),
        "slow_phase": slow_phase,
    }
    if motion.contact_s == 0.0:  # always in the middle of a contact
        return LoadPlan(0.0, 0.0, 1.0, 1.0, 1.0, **drift)
    cycle_s = motion.contact_s + motion.lifted_s
    return LoadPlan(
        turns_per_s=1.0 / cycle_s,
        phase=-0.5 * motion.contact_s / cycle_s,
        cycle_s=cycle_s,
        half_contact_s=0.5 * motion.contact_s,
        per_landing=1.0 / motion.landing_s,
        **drift,
    )
