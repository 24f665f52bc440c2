"""A limit that is higher while the tip sticks: slow fingers stick and slip, fast ones do not feel it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.physics.friction_limit import static_coefficients, static_step

CALM = {
    "motion.tremor_um": 0.0,
    "motion.tremor_n": 0.0,
    "motion.load_drift": 0.0,
    "friction.roughness_rms": 0.0,
    "friction.occlusion_ratio": 1.0,
    "motion.stroke_mm": 200.0,
    "motion.start": 0.25,
}


def plain(speed_mm_s, ratio, length_um, duration_s=3.0):
    """f_a over the last second of a slow stroke without vibration."""
    changes = {"motion.speed_mm_s": speed_mm_s, "friction.static_ratio": ratio, "finger.slip_length_um": length_um}
    return fl.plain_stroke(fl.bench().evolve(CALM | changes), 0.0, duration_s)["f_a"].values[-5000:]


@given(st.floats(-10, 10), st.floats(1, 5), st.floats(0.1, 100))
def test_the_factor_is_the_formula_and_between_one_and_the_ratio(slip, ratio, static_mm_s):
    friction = fl.FingerFriction(static_ratio=ratio, static_mm_s=static_mm_s)
    found = static_step(slip, *static_coefficients(friction))
    assert 1.0 <= found <= ratio * (1 + 1e-12)
    exponent = min((slip / (1e-3 * static_mm_s)) ** 2, 690.0)
    assert found == pytest.approx(1 + (ratio - 1) * math.exp(-exponent), rel=1e-12)


@pytest.mark.parametrize("length_um", [11.5, 30.0, 0.0])
def test_a_fast_finger_slides_at_its_kinetic_limit(length_um):
    np.testing.assert_allclose(plain(20.0, 1.4, length_um), 0.95, rtol=1e-6)


@pytest.mark.parametrize("length_um", [11.5, 30.0, 0.0])
def test_a_slow_finger_sticks_and_slips_only_with_a_static_share(length_um):
    # At 2 mm/s dF/dv is far below -c of the skin: steady sliding cannot be stable there.
    assert np.ptp(plain(2.0, 1.0, length_um)) < 1e-6
    force = plain(2.0, 1.4, length_um)
    assert np.ptp(force) > 0.1
    assert force.max() <= 1.4 * 0.95 * (1 + 1e-9)


def test_a_creeping_finger_carries_the_static_force():
    # (0.5/2)^2 = 1/16. A long contact gives way by creeping, so this slide is steady, after the skin's 1.3 mm.
    force = plain(0.5, 1.4, 100.0, 7.0)
    assert force == pytest.approx(0.95 * (1 + 0.4 * math.exp(-1 / 16)), rel=1e-3)
