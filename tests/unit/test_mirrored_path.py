"""A path and its mirror give the same forces along the motion, pauses included."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictionloop as fl

QUIET = {
    "friction.roughness_rms": 0.0, "touch.position.noise_um": 0.0, "touch.load.noise_n": 0.0,
    "sensor.noise_density_n_rthz": 0.0, "motion.contact_s": 100.0, "sensor.adc_bits": 32,
}  # fmt: skip
RIGID = {"finger": fl.RigidFinger()}


def felt(system, path):
    """Return the force on the finger, the measurement and validity of each period of a path, in the air at first."""
    loop = fl.Stepper(system.evolve(QUIET))
    loop.tick(0.0, fl.Movement(path[0][0], 0.0, 0.0))
    rows = []
    for position, speed, load in path:
        seen = loop.tick(1.2, fl.Movement(position, speed, load))
        rows.append((loop.force_n, seen.force, seen.position, seen.speed, seen.valid))
    return np.array(rows)


def mirrored(path):
    return [(-position, -speed, load) for position, speed, load in path]


@settings(max_examples=15)
@given(
    st.lists(
        st.tuples(st.sampled_from([-0.08, -0.02, 0.0, 0.0, 0.02, 0.15]), st.integers(5, 200)), min_size=1, max_size=8
    )
)
@pytest.mark.parametrize("finger", [{}, RIGID], ids=["skin", "rigid"])
def test_a_path_and_its_mirror(finger, stretches):
    speeds = np.concatenate([np.full(n, v) for v, n in [(-0.05, 100), *stretches]])
    path = list(zip(np.cumsum(speeds) / 5000, speeds, np.full(speeds.size, 0.5), strict=True))
    system = fl.bench().evolve(finger)
    forth, back = felt(system, path), felt(system, mirrored(path))
    np.testing.assert_allclose(back[100:] * [1, 1, -1, -1, 1], forth[100:], rtol=1e-12, atol=1e-14)


def test_a_pause_turns_no_force():
    """Strokes back in whole pixels, every fourth block without one: no force along the motion below zero."""
    speeds = np.where(np.arange(3000) // 25 % 4 == 3, 0.0, -0.08 / 3)
    path = list(zip(np.cumsum(speeds) / 5000, speeds, np.full(speeds.size, 0.5), strict=True))
    force_n, measured_n = felt(fl.bench(), path)[1500:, :2].T
    assert force_n.min() > 0.3
    assert measured_n.min() > 0.2


@pytest.mark.parametrize("speed", [0.005, 0.15])
def test_a_finger_that_begins_backwards_on_the_plate_is_believed_once_its_skin_is_stretched(speed):
    loop = fl.Stepper(fl.bench().evolve(QUIET))
    path = [fl.Movement(-speed * k / 5000, -speed, 0.5) for k in range(1, 1501)]
    seen = [loop.tick(1.2, each) for each in path]
    assert min(each.force for each in seen if each.valid) > 0.2
