"""The error with turns, the force after a turn and the share of feedback: a run against the sums that a sweep keeps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.device.recording import away_from_turns
from frictionloop.loop.companion_runs import TURNS
from frictionloop.loop.transients import _turns_s, reversal_metrics

HOLD = {"setpoint": fl.Constant(offset_n=0.6), "motion.speed_mm_s": 80.0, "motion.stroke_mm": 60.0}


def plain(**changes):
    names = ("position", "speed", "load", "f_a", "f_r", "sliding", "scored")
    time = np.arange(10_000) / 5000
    given = dict.fromkeys(names, time >= 0.0) | changes
    import xarray as xr

    return xr.Dataset({name: ("time", values) for name, values in given.items()}, {"time": time})


def test_a_triangle_has_the_peaks_that_it_was_given():
    t = np.arange(10_000) / 5000
    position = 0.02 * np.abs((t + 0.25) % 1.0 - 0.5)  # turns at 0.25, 0.75, 1.25 and 1.75 s; back by 1 mm 50 ms later
    force = 0.5 + 0.3 * (abs(t - 0.35) < 0.01) + 0.1 * (abs(t - 0.9) < 0.01) + 0.2 * (abs(t - 1.45) < 0.01)
    run = plain(position=position, speed=np.gradient(position, t), f_a=force, f_r=0 * t + 0.5, load=0 * t + 0.5)
    assert _turns_s(t, position) == pytest.approx([0.3, 0.8, 1.3, 1.8], abs=6e-3)
    found = reversal_metrics(run, np.ones(t.size, bool))
    assert found["turn_peak"] == pytest.approx((0.8 + 0.6 + 0.7) / 3)  # the last has less than 0.25 s left
    assert found["rms_error_turns"] == pytest.approx(np.sqrt(np.mean((force - 0.5) ** 2)))


@pytest.mark.parametrize("controller", ["notch_pi", "lookup"])
def test_a_sweep_keeps_the_numbers_of_the_run(controller):
    system = fl.bench().evolve(HOLD | {"controller.kind": controller})
    run = fl.simulate(system, 6.0, seed=2)
    grid = fl.sweep(system, [{}], 6.0, seeds=[2], metrics=list(TURNS), progress=False)
    of_run = fl.metrics(run)
    for name in TURNS:
        # The run looks for turns every 5 ms: a peak in between is the same one.
        assert grid[name].item() == pytest.approx(of_run[name], rel=1e-6), name
    assert 0.9 < of_run["feedback_share"] < 1.0
    assert of_run["rms_error_turns"] > of_run["rms_error"]


def test_a_finger_that_nobody_moves_has_no_turn():
    grid = fl.sweep(fl.feasible(), [{}], 1.0, metrics=["rms_error", *TURNS], progress=False)
    assert grid["rms_error_turns"].item() == pytest.approx(grid["rms_error"].item(), rel=1e-12)
    assert np.isnan(grid["turn_peak"].item())


def test_strokes_shorter_than_a_turn_takes_are_warned_of():
    system = fl.bench().evolve({"motion.stroke_mm": 1.25, "motion.speed_mm_s": 5.0, "motion.tremor_um": 0.0})
    with pytest.warns(fl.SignalWarning, match=r"NO-FEEDBACK: motion\.stroke_mm 1\.25 mm"):
        run = fl.simulate(system, 1.0)
    assert not run.sliding.values[run.time.values > 0.5].any()
    fl.simulate(system.evolve({"controller.kind": "lookup"}), 0.1)


# Samples near a turn: a triangle in closed form, and the simulator's own rule about its strokes.


def test_a_triangle_is_left_out_at_its_corners():
    position = np.concatenate([np.arange(0.0, 10.0, 0.1), np.arange(10.0, 0.0, -0.1), np.arange(0.0, 10.0, 0.1)])
    speed = np.repeat([1.0, -1.0, 1.0], 100)
    away = away_from_turns(position, speed, 1.95)
    expected = np.ones(300, bool)
    expected[81:120] = expected[181:220] = False  # 1.9 on both sides of 10 and of 0; the ends of the run are no turns
    assert np.array_equal(away, expected)


def test_rest_and_lost_samples_are_no_turns():
    position = np.linspace(0.0, 1.0, 50)
    speed = np.ones(50)
    speed[10:20], speed[30:35], position[30:35] = 0.0, np.nan, np.nan
    assert away_from_turns(position, speed, 5.0).all()
    assert away_from_turns(position, np.zeros(50), 5.0).all()


@pytest.mark.parametrize("speed_mm_s", [20.0, 50.0])
def test_what_is_left_out_is_what_the_simulator_does_not_score(speed_mm_s):
    system = fl.bench().evolve({"motion.speed_mm_s": speed_mm_s})
    run = fl.simulate(system, duration_s=13.0)
    away = away_from_turns(
        run.position.values, run.speed.values, 2.0 * system.motion.unscored_n / system.finger.stiffness_n_m
    )
    # It scores by the true position within the stroke; ours is the measured one, from a turn seen a little late.
    after = run.time.values > 0.2  # the stroke begins at its end, and nobody saw that turn
    assert (~away).sum() > 1000
    assert (away != run.scored.values.astype(bool))[after].mean() < 0.005


# A path and its mirror give the same forces along the motion, pauses included.


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
