"""A contact that ages at rest: rested it breaks loose with a peak, slow it sticks and slips, fast it slides."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import frictionloop as fl
from frictionloop.physics.limit_scaling import aged_step, ageing_coefficients, ageing_step

CALM = {
    "motion.tremor_um": 0.0,
    "motion.tremor_n": 0.0,
    "motion.load_drift": 0.0,
    "friction.roughness_rms": 0.0,
    "friction.occlusion_ratio": 1.0,
    "motion.stroke_mm": 200.0,
    "motion.start": 0.25,
}
AGES = fl.FingerFriction(static_ratio=1.44)
STEADY_20 = 1.0 + 0.44 * math.log(1.05) / math.log(11.0)
"""Factor at 20 mm/s, where the contact is 0.1 mm/(20 mm/s) = 5 ms old."""


def plain(speed_mm_s, ratio, length_um, duration_s=3.0):
    """f_a over the last second of a slow stroke without vibration."""
    changes = {"motion.speed_mm_s": speed_mm_s, "friction.static_ratio": ratio, "finger.slip_length_um": length_um}
    return fl.plain_stroke(fl.bench().evolve(CALM | changes), 0.0, duration_s)["f_a"].values[-5000:]


def rested(rest_s, ratio, speed_mm_s=40.0, slide_s=0.2):
    """f_a of a finger that rests and then slides, over the slide."""
    loop = fl.Stepper(fl.bench().evolve(CALM | {"friction.static_ratio": ratio}))
    rest, slide = (round(5000 * each) for each in (rest_s, slide_s))
    forces = []
    for tick in range(rest + slide):
        moved = max(tick + 1 - rest, 0)
        speed = 1e-3 * speed_mm_s if moved else 0.0
        loop.tick(0.0, fl.Movement(speed * moved / 5000, speed, 0.5))
        forces.append(loop.force_n)
    return np.array(forces[rest:])


@given(st.floats(0, 100), st.floats(1, 5), st.floats(1e-3, 10))
def test_the_limit_rises_with_the_logarithm_of_age(age_s, ratio, static_s):
    friction = fl.FingerFriction(static_ratio=ratio, static_s=static_s)
    expected = 1 + (ratio - 1) * math.log(1 + age_s / static_s) / math.log(1 + 1 / static_s)
    assert aged_step(age_s, ageing_coefficients(friction)) == pytest.approx(expected, rel=1e-9)


def test_age_follows_its_law_through_rest_and_slip():
    def slip(t):
        return 0.02 * max(math.sin(7.0 * t), 0.0)

    def law(t, age):
        return 1.0 - slip(t) * age / 1e-4

    expected = solve_ivp(law, (0.0, 2.0), [0.0], rtol=1e-10, atol=1e-12, max_step=1e-3, dense_output=True).sol
    age, dt, found = 0.0, 2e-5, []
    for step in range(100_000):
        age = ageing_step(age, slip((step + 0.5) * dt), 0.5, dt, ageing_coefficients(AGES))
        found.append(age)
    times = dt * np.arange(1, 100_001)
    np.testing.assert_allclose(found, expected(times)[0], atol=2e-4)


@given(st.floats(0, 1e3), st.floats(-10, 10), st.floats(1e-5, 1e-3))
def test_age_is_never_negative_and_gone_when_lifted(age_s, slip, dt):
    constants = ageing_coefficients(AGES)
    assert 0.0 <= ageing_step(age_s, slip, 0.5, dt, constants) <= age_s + dt
    assert ageing_step(age_s, slip, 0.0, dt, constants) == 0.0


@pytest.mark.parametrize("length_um", [11.5, 30.0, 0.0])
def test_a_fast_finger_slides_at_the_limit_of_its_age(length_um):
    expected = plain(20.0, 1.0, length_um) * STEADY_20
    np.testing.assert_allclose(plain(20.0, 1.44, length_um), expected, rtol=1e-6)


@pytest.mark.parametrize("length_um", [11.5, 30.0, 0.0])
def test_a_slow_finger_sticks_and_slips_only_if_its_contact_ages(length_um):
    assert np.ptp(plain(2.0, 1.0, length_um)) < 1e-6
    assert np.ptp(plain(2.0, 3.0, length_um)) > 0.1


def test_a_rested_finger_breaks_loose_with_a_peak_that_grows_with_rest():
    peaks = []
    for rest_s in (0.05, 0.4, 1.4):
        force = rested(rest_s, 1.44)
        peaks.append(force.max() / force[-1])
        assert peaks[-1] <= 1 + 0.44 * math.log(1 + (rest_s + 0.2) / 0.1) / math.log(11.0)
    assert 1.0 < peaks[0] < peaks[1] < peaks[2]
    assert rested(1.4, 1.0).max() / rested(1.4, 1.0)[-1] == pytest.approx(1.0, abs=1e-3)
