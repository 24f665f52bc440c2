"""Friction of a rough contact: closed form, its inverse, its slope in the linear analysis, and in the loop."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.parameters.written import write_toml
from frictionloop.physics.rough_contact import VIBRATION

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
