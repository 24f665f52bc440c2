"""Strokes and load in closed form: against the speed profile integrated piece by piece, over a million periods."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit
from scipy.interpolate import PPoly

from frictionloop.parameters.motion import Sliding, Strokes
from frictionloop.physics.motion import load_plan, load_step, stroke_plan, stroke_step

RATE_HZ = 5000.0
LANES = 32


@njit
def strokes_over(times, plan):
    out = np.empty((times.size, 2))
    for i in range(times.size):
        out[i] = stroke_step(times[i], plan)
    return out


@njit
def loads_over(times, tremor, plan):
    out = np.empty(times.size)
    for i in range(times.size):
        out[i] = load_step(times[i], tremor, plan)
    return out


def motions():
    def build(speed, stroke, share, start):
        return Strokes(
            speed_mm_s=speed, stroke_mm=stroke, reversal_s=share * 1.6 * stroke / speed * (1 - 1e-12), start=start
        )

    return st.builds(build, st.floats(1, 500), st.floats(1, 250), st.floats(0.01, 1.0), st.floats(0, 1))


def profile(motion):
    """Speed in m/s over a cycle that begins mid-stroke, as cubic pieces; its integral is the position."""
    v, r, h = 1e-3 * motion.speed_mm_s, motion.reversal_s, motion.plateau_s / 2
    breaks = np.cumsum([0.0, h, r, 2 * h, r, h])
    z = np.poly1d([-2 / r, 1.0])  # from 1 to -1 over a reversal
    turn = np.pad(v * ((3 * z - z**3) / 2).coeffs, (0, 0))
    plateau = np.array([0.0, 0.0, 0.0, v])
    return PPoly(np.array([plateau, turn, -plateau, -turn, plateau]).T, breaks)


@given(motions(), st.floats(0, 1))
def test_a_cycle_is_the_speed_profile_and_its_integral(motion, share):
    speed = profile(motion)
    position = speed.antiderivative()
    assert speed.x[-1] == pytest.approx(motion.cycle_s, rel=1e-12)
    t = share * motion.cycle_s
    since = (t + (motion.start - 0.25) * motion.cycle_s) % motion.cycle_s
    x, v = stroke_step(t, stroke_plan(motion))
    # Phases round at 1e-16 of a cycle; the steepest change of speed is 3 v/R.
    slack = 1e-14 * motion.cycle_s
    full = 1e-3 * motion.speed_mm_s
    assert x == pytest.approx(float(position(since)), abs=full * slack + 1e-14 * 1e-3 * motion.stroke_mm)
    assert v == pytest.approx(float(speed(since)), abs=3 * full / motion.reversal_s * slack + 1e-13 * full)


@given(motions(), st.floats(0, 1e3))
def test_the_finger_stays_on_its_stroke_and_below_its_speed(motion, t):
    x, v = stroke_step(t, stroke_plan(motion))
    assert abs(x) <= 0.5e-3 * motion.stroke_mm * (1 + 1e-12)
    assert abs(v) <= 1e-3 * motion.speed_mm_s * (1 + 1e-15)


def test_it_reaches_both_ends_and_slides_at_the_speed_asked_for():
    motion = Strokes()
    plan = stroke_plan(motion)
    assert motion.plateau_s == pytest.approx(60 / 20 - 0.0625)
    assert stroke_step(0.0, plan) == pytest.approx((-0.03, 0.0), abs=1e-15)
    assert stroke_step(motion.cycle_s / 2, plan) == pytest.approx((0.03, 0.0), abs=1e-15)
    assert stroke_step(motion.cycle_s / 4, plan) == pytest.approx((0.0, 0.02), abs=1e-15)
    assert stroke_step(motion.cycle_s / 4, plan)[1] == 0.02  # exactly, not to rounding
    assert stroke_step(motion.cycle_s * 0.75, plan)[1] == -0.02


def test_speed_is_the_derivative_of_position_and_has_no_jumps():
    motion = Strokes(reversal_s=0.2, stroke_mm=10.0)
    times = np.arange(0, 2 * motion.cycle_s, 1e-4)
    x, v = strokes_over(times, stroke_plan(motion)).T
    # Central differences err by h^2 x'''/6; x''' <= 6 v / (R/2)^2 / 2 (second derivative of the cubic).
    third = 3 * 0.02 / 0.1**2
    np.testing.assert_allclose((x[2:] - x[:-2]) / 2e-4, v[1:-1], rtol=0, atol=1e-8 * third / 3)
    assert np.max(np.abs(np.diff(v))) <= 1e-4 * 3 * 0.02 / 0.2 * (1 + 1e-9)  # 3 v/R per second at the turn


def test_nothing_drifts_over_a_million_periods():
    motion = Strokes()
    plan = stroke_plan(motion)
    # The rate as the plan has it; what is tested is that time adds nothing to it.
    rate = Fraction(plan.turns_per_s)
    for k in (999_983, 1_000_000, 1_000_003):
        t = k / RATE_HZ
        turns = Fraction(t) * rate
        late, early = stroke_step(t, plan), stroke_step(float((turns % 1) / rate), plan)
        # 33 cycles: the phase rounds at 33 * 2^-53 of a cycle of 6.1 s.
        assert late[0] == pytest.approx(early[0], abs=0.02 * 6.1 * 33 * 2**-52)


@given(motions(), st.lists(st.floats(0, 100), min_size=LANES, max_size=LANES))
def test_lanes_have_the_bits_of_a_single_step(motion, times):
    plan = stroke_plan(motion)
    together = strokes_over(np.array(times), plan)
    assert [tuple(row) for row in together] == [stroke_step(t, plan) for t in times]
    load = load_plan(motion, 3)
    assert list(loads_over(np.array(times), 0.01, load)) == [load_step(t, 0.01, load) for t in times]


def test_load_lands_stays_and_lifts():
    motion = Strokes(load_drift=0.0, contact_s=1.0, lifted_s=0.4, landing_s=0.1)
    plan = load_plan(motion, 0)
    times = np.arange(0, 14.0, 1e-3)
    since = times % 1.4
    edge = np.clip(np.minimum(since, 1.0 - since) / 0.1, 0, 1)
    load = loads_over(times, 0.0, plan)
    np.testing.assert_allclose(load, 0.5 * edge**2 * (3 - 2 * edge), rtol=0, atol=1e-12)
    lifted = (since > 1.0 + 1e-9) & (since < 1.4 - 1e-9)
    assert np.all(loads_over(times, 0.03, plan)[lifted] == 0.0)
    assert np.all(loads_over(times, 0.03, plan)[~lifted] >= 0.0)


@given(st.floats(0, 1e4), st.floats(0, 0.49), st.floats(-10, 10), st.integers(0, 2**63))
def test_a_finger_that_never_lifts_keeps_its_load(t, drift, tremor, seed):
    motion = Strokes(load_drift=drift, load_n=0.7)
    load = load_step(t, tremor, load_plan(motion, seed))
    assert load >= 0.0
    low, high = 0.7 * (1 - 2 * drift) + tremor, 0.7 * (1 + 2 * drift) + tremor
    assert max(low, 0) - 1e-12 <= load <= max(high, 0) + 1e-12


def test_drift_has_the_standard_deviation_asked_for():
    motion = Strokes(load_drift=0.1, load_drift_s=0.5)
    drift = loads_over(np.arange(0, 500.0, 0.01), 0.0, load_plan(motion, 7)) - 0.5
    # Two sines of 1000 and 618 periods: their means and product vanish to about 1/(2 pi 382).
    assert np.mean(drift) == pytest.approx(0, abs=0.05 * 1e-3)
    assert np.std(drift) == pytest.approx(0.05, rel=1e-3)


def test_seeds_drift_apart():
    loads = {load_step(0.0, 0.0, load_plan(Strokes(), seed)) for seed in range(20)}
    assert len(loads) == 20


def test_the_longest_reversal_leaves_no_plateau():
    motion = Strokes(reversal_s=4.8)
    assert motion.plateau_s == pytest.approx(0, abs=1e-15)
    assert max(abs(stroke_step(t, stroke_plan(motion))[0]) for t in np.linspace(0, 10, 1001)) <= 0.03 * (1 + 1e-12)
    assert math.isclose(motion.cycle_s, 9.6)
    assert Sliding().kind == "sliding"
