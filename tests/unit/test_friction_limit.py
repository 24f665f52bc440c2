"""The modifiers of the friction limit: each against its equation, together never negative, and 0 when lifted."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit
from scipy.integrate import solve_ivp

from frictionloop.parameters import Friction
from frictionloop.parameters.plant import FingerFriction, FrictionLaw, RigidFinger, Skin
from frictionloop.physics.friction import friction_force, halving_amplitude_um
from frictionloop.physics.friction_limit import (
    limit_coefficients,
    limit_step,
    occlusion_coefficients,
    occlusion_step,
)
from frictionloop.physics.vibration import vibrated_step
from frictionloop.quantities import FrictionloopError

DT = 2e-4
EPS = 2.0**-52
frictions = st.builds(
    FingerFriction,
    load_exponent=st.floats(0, 2),
    speed_slope=st.floats(-0.15, 0.15),
    reference_load_n=st.floats(0.1, 2),
    reference_speed_mm_s=st.floats(1, 200),
    slow_mm_s=st.floats(0.01, 10),
    occlusion_ratio=st.floats(0.1, 10),
    moist_loss=st.floats(0, 0.9),
)
loads, speeds, shares = st.floats(1e-6, 20), st.floats(-1, 1), st.floats(0, 1)


@njit
def limits(load, speed, occluded, roughness, coefficients):
    out = np.empty(load.size)
    for i in range(load.size):
        out[i] = limit_step(load[i], speed[i], occluded[i], roughness[i], coefficients)
    return out


@given(frictions, loads, speeds, shares, st.floats(-0.9, 2))
def test_the_factor_is_the_product_of_its_parts(friction, load, speed, occluded, roughness):
    slow, reference = 1e-3 * friction.slow_mm_s, 1e-3 * friction.reference_speed_mm_s
    exact = (
        (load / friction.reference_load_n) ** friction.load_exponent
        * (math.hypot(speed, slow) / math.hypot(reference, slow)) ** friction.speed_slope
        * (1 + (friction.occlusion_ratio - 1) * occluded)
        * (1 + roughness)
    )
    got = limit_step(load, speed, occluded, roughness, limit_coefficients(friction))
    # Exponents of up to 60 octaves are rounded a few times; so is 1 + roughness, at 0.1 and above.
    assert got == pytest.approx(exact, rel=200 * EPS)


def test_it_is_one_at_the_reference():
    friction = FingerFriction(speed_slope=0.1)
    assert limit_step(0.5, 0.02, 0.0, 0.0, limit_coefficients(friction)) == pytest.approx(1.0, rel=4 * EPS)
    assert limit_step(0.5, -0.02, 0.0, 0.0, limit_coefficients(friction)) == pytest.approx(1.0, rel=4 * EPS)


@given(frictions, st.floats(-100, 100), speeds, shares, st.floats(-10, 10))
def test_it_is_never_negative_and_zero_without_load(friction, load, speed, occluded, roughness):
    got = limit_step(load, speed, occluded, roughness, limit_coefficients(friction))
    assert 0 <= got < math.inf
    if load <= 0 or roughness <= -1:
        assert got == 0.0


@given(frictions, shares)
def test_slow_sliding_has_a_limit(friction, occluded):
    coefficients = limit_coefficients(friction)
    still = limit_step(0.5, 0.0, occluded, 0.0, coefficients)
    assert 0 < still < math.inf
    slow = 1e-3 * friction.slow_mm_s
    # (1 + 1e-6)^(p/2) - 1 at a thousandth of the slow speed.
    assert limit_step(0.5, 1e-3 * slow, occluded, 0.0, coefficients) == pytest.approx(still, rel=1e-7)


def test_the_slope_far_from_slow():
    friction = FingerFriction(speed_slope=-0.12, slow_mm_s=0.1)
    coefficients = limit_coefficients(friction)
    ratio = limit_step(0.5, 0.1, 0.0, 0.0, coefficients) / limit_step(0.5, 0.05, 0.0, 0.0, coefficients)
    # vs^2 changes the logarithmic slope by its share in v^2, 4e-6 at 50 mm/s.
    assert math.log2(ratio) == pytest.approx(-0.12, rel=1e-5)


@given(st.floats(1, 100), st.floats(1, 100))
def test_occlusion_follows_its_equation(occlusion_s, drying_s):
    coefficients = occlusion_coefficients(FingerFriction(occlusion_s=occlusion_s, drying_s=drying_s), 0.1)
    w, load = 0.0, [1.0] * 50 + [0.0] * 30 + [0.2] * 20
    for each in load:
        w = occlusion_step(w, each, coefficients)
    exact = 0.0
    for seconds, target, t in ((5, 1, occlusion_s), (3, 0, drying_s), (2, 1, occlusion_s)):
        exact = target + (exact - target) * math.exp(-seconds / t)
    assert w == pytest.approx(exact, abs=100 * 4 * EPS)


def test_occlusion_against_an_integrator():
    friction = FingerFriction(occlusion_s=2.0, drying_s=5.0)
    coefficients, w = occlusion_coefficients(friction, DT), 0.0
    for k in range(10_000):
        w = occlusion_step(w, float(k < 6000), coefficients)
    rise = solve_ivp(lambda _, y: (1 - y) / 2.0, (0, 1.2), [0.0], rtol=1e-11, atol=1e-13).y[0, -1]
    fall = solve_ivp(lambda _, y: -y / 5.0, (0, 0.8), [rise], rtol=1e-11, atol=1e-13).y[0, -1]
    assert w == pytest.approx(fall, rel=1e-9)


def test_a_lifted_finger_neither_slides_nor_occludes():
    friction = FingerFriction()
    assert occlusion_step(0.0, 0.0, occlusion_coefficients(friction, DT)) == 0.0
    assert occlusion_step(0.5, 0.0, occlusion_coefficients(friction, DT)) < 0.5
    assert limit_step(0.0, 0.02, 0.5, 0.0, limit_coefficients(friction)) == 0.0


@given(st.floats(0, 2.5), shares, st.floats(0, 0.9), st.floats(0.05, 2))
def test_moisture_lowers_the_susceptibility(a, occluded, loss, tau):
    moist = Friction(nominal_n=1.0, susceptibility_per_um2=tau * (1 - loss * occluded))
    y = a / float(halving_amplitude_um(tau))
    exact = float(friction_force(a, moist))
    assert vibrated_step(y, occluded, loss) == pytest.approx(exact, rel=8 * EPS * (1 + tau * a * a))


@given(frictions, st.lists(st.tuples(loads, speeds, shares, st.floats(-1, 1)), min_size=32, max_size=32))
def test_lanes_have_the_bits_of_a_single_step(friction, lanes):
    coefficients = limit_coefficients(friction)
    together = limits(*np.array(lanes).T.copy(), coefficients)
    assert list(together) == [limit_step(*lane, coefficients) for lane in lanes]


@pytest.mark.parametrize(
    ("block", "values"),
    [
        (FingerFriction, {"load_exponent": -0.1}),
        (FingerFriction, {"reference_load_n": 0.0}),
        (FingerFriction, {"occlusion_ratio": 0.0}),
        (FingerFriction, {"moist_loss": 1.0}),
        (FingerFriction, {"roughness_rms": -0.01}),
        (FingerFriction, {"slow_mm_s": 0.0}),
        (FingerFriction, {"kind": "glove"}),
        (Skin, {"stiffness_n_m": 0.0}),
        (Skin, {"mass_kg": -1e-4}),
        (Skin, {"contact": "glue"}),
        (RigidFinger, {"stiffness_n_m": 1.0}),
    ],
)
def test_impossible_fingers_are_refused(block, values):
    with pytest.raises(FrictionloopError):
        block(**values)


def test_a_finger_has_the_friction_law_of_the_paper_within_it():
    assert isinstance(FingerFriction(), FrictionLaw)
    assert float(friction_force(0.0, FingerFriction(nominal_n=0.7))) == 0.7
