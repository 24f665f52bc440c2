"""Equation (1): the friction law, its inverse, its slope and what it can reach."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.parameters.toml_writer import write_toml
from frictionloop.physics.friction import halving_amplitude_um, remaining_step
from frictionloop.physics.rough_contact import VIBRATION

finger = st.builds(fl.Friction, nominal_n=st.floats(0.1, 10), susceptibility_per_um2=st.floats(0.01, 10))
amplitude = st.floats(0, 5)
EPS = 2.0**-52


@given(finger, amplitude)
def test_the_compiled_step_is_equation_1(friction, a):
    f0, tau = friction.nominal_n, friction.susceptibility_per_um2
    exact = f0 * math.exp(-tau * a * a)
    # The exponent tau a^2 <= 250 is rounded a few times, which the exponential turns into a relative error.
    tolerance = 8 * EPS * (1 + tau * a * a)
    assert f0 * remaining_step(a / halving_amplitude_um(tau)) == pytest.approx(exact, rel=tolerance)
    assert fl.friction_force(a, friction) == pytest.approx(exact, rel=tolerance)


def test_values_of_the_paper():
    friction = fl.paper().friction
    assert fl.friction_force(0.0, friction) == 0.8
    # 0.38 * 2.5^2 = 2.375; e^-2.375 = 0.09301448921066349 (any table of exponentials)
    assert fl.friction_force(2.5, friction) == pytest.approx(0.8 * 0.09301448921066349, rel=1e-14)


@given(finger, st.floats(1e-3, 1))
def test_the_amplitude_for_a_force_gives_that_force(friction, share):
    force = share * friction.nominal_n
    a = fl.amplitude_for(force, friction)
    assert fl.friction_force(a, friction) == pytest.approx(force, rel=30 * EPS)  # ln 1000 = 7: 8 EPS (1 + 7) / 2


def test_no_amplitude_outside_what_friction_can_be():
    got = fl.amplitude_for([-0.1, 0.0, 0.8000001, 0.8, np.nan], fl.paper().friction)
    np.testing.assert_array_equal(np.isnan(got), [True, True, True, False, True])
    assert got[3] == 0.0


@given(finger, st.lists(amplitude, min_size=2, max_size=5))
def test_vibration_only_lowers_friction(friction, amplitudes):
    forces = fl.friction_force(np.sort(amplitudes), friction)
    assert np.all(np.diff(forces) <= 0)
    assert np.all((forces >= 0) & (forces <= friction.nominal_n))


def test_reachable_band():
    system = fl.paper()
    floor = 0.8 * math.exp(-0.38 * 6.25)
    assert fl.reachable(system) == pytest.approx((floor, 0.8), rel=1e-15)
    assert fl.reachable(system, np.array([0.1, 0.3, 0.2])) == pytest.approx((floor + 0.3, 0.9), rel=1e-15)
    assert fl.reachable(system, 0.4) == pytest.approx((floor + 0.4, 1.2), rel=1e-15)


SYSTEM = fl.bench().evolve({"friction.kind": "rough_contact"})


@given(st.floats(0.05, 2.0), st.floats(0.0, 10.0), st.floats(0.0, 1.0))
def test_share_is_an_exponential_and_the_inverse_undoes_it(tau, amplitude_um, occluded):
    friction = SYSTEM.friction.model_copy(update={"susceptibility_per_um2": tau})
    coefficients = VIBRATION.coefficients_of(friction)
    share = VIBRATION.step(amplitude_um, occluded, coefficients)
    exponent = math.sqrt(tau * (1 - friction.moist_loss * occluded)) * amplitude_um
    # exp2 errs by 4e-12, and the exponent is rounded a few times.
    assert share == pytest.approx(math.exp(-exponent), rel=1e-11 + 1e-15 * exponent)
    assert VIBRATION.inverse(0.9, 0.9 * share, occluded, coefficients) == pytest.approx(
        amplitude_um, rel=1e-9, abs=1e-9
    )


def test_both_laws_leave_the_same_at_one_amplitude():
    tau = SYSTEM.friction.susceptibility_per_um2
    left = [float(fl.friction_force(tau**-0.5, system.friction)) for system in (SYSTEM, fl.bench())]
    assert left[0] == pytest.approx(SYSTEM.friction.nominal_n / math.e, rel=1e-11)
    assert left[0] == pytest.approx(left[1], rel=1e-11)


def test_the_kind_is_read_and_written(tmp_path):
    path = tmp_path / "bench.toml"
    write_toml(SYSTEM, path)
    assert fl.read_toml(path) == SYSTEM
    assert type(SYSTEM.friction).__name__ == "RoughContactFriction"


@pytest.mark.slow
def test_the_loop_has_the_law():
    """Of a rigid finger that never grows moist, on a smooth plate at its reference load and speed, the law is all."""
    smooth = {"friction.roughness_rms": 0.0, "friction.occlusion_ratio": 1.0, "friction.moist_loss": 0.0}
    still = {"motion.tremor_um": 0.0, "motion.tremor_n": 0.0, "motion.load_drift": 0.0, "motion.stroke_mm": 200.0}
    run = fl.simulate(SYSTEM.evolve({**smooth, **still, "finger.kind": "rigid", "controller.kind": "lookup"}), 1.0)
    sliding = run.isel(time=slice(2500, None))
    assert float(np.ptp(sliding.a.values)) > 0.1
    np.testing.assert_allclose(sliding.f_a, fl.friction_force(sliding.a.values, SYSTEM.friction), rtol=1e-6)
