"""The plant alone, one period at a time, is the plant of ``simulate``."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.loop.live_loop import MOST, Guided

BASE = fl.paper().evolve({"setpoint.sweep_s": 0.1, "sensor.noise_rms_n": 1e-3})


@pytest.fixture
def recording(tmp_path):
    path = tmp_path / "force.csv"
    np.savetxt(path, 0.2 + 0.1 * np.sin(np.arange(101) / 7.0))
    return fl.Recording(path=str(path), rate_hz=5000.0)


def commands(system, run):
    """Return the amplitude command of each period as the kernel computes it."""
    from frictionloop.control.lookup import inverse_step

    model = system.controller.model
    constants = (np.log2(model.nominal_n), math.log(2.0) / model.susceptibility_per_um2)
    return [inverse_step(u, *constants) for u in run["u"].values]


def replay(system, duration_s, seed=0):
    run = fl.simulate(system, duration_s, seed)
    loop = fl.Stepper(system, seed)
    forces, amplitudes = [loop.measured.force], [loop.amplitude_um]
    for command in commands(system, run)[:-1]:
        forces.append(loop.tick(command).force)
        amplitudes.append(loop.amplitude_um)
    np.testing.assert_array_equal(forces, run["f_m"].values)
    np.testing.assert_array_equal(amplitudes, run["a"].values)
    return loop, run


@pytest.mark.parametrize(
    "overrides",
    [
        {},
        {"controller.delay_s": 200e-6},
        {"controller.delay_s": 330e-6},
        {"controller.kp": 40.0},
        {"disturbance": fl.Constant(offset_n=0.1)},
        {"disturbance": fl.Steps(times_s=(0.0, 0.01), levels_n=(0.1, 0.4))},
        {"disturbance": fl.ColouredNoise(offset_n=0.2, rms_n=0.05)},
        {"disturbance": fl.LogSweep(offset_n=0.2, amplitude_n=0.1, sweep_s=0.1)},
        {"setpoint": fl.ColouredNoise(offset_n=0.6, rms_n=0.1)},
    ],
    ids=str,
)
def test_a_runs_commands_give_a_runs_measurements(overrides):
    replay(BASE.evolve(overrides), 0.1, seed=21)


def test_a_recording_to_its_last_sample(recording):
    system = BASE.evolve({"disturbance": recording})
    loop, _ = replay(system, 0.02)
    loop.tick(1.0)  # the 100th period ends on the 101st sample
    loop.tick(1.0)  # which is held for a period of its own
    with pytest.raises(fl.FrictionloopError, match=r"force\.csv"):
        loop.tick(1.0)


def test_a_swept_disturbance_ends():
    loop = fl.Stepper(BASE.evolve({"disturbance": fl.LogSweep(sweep_s=0.001)}))
    for _ in range(5):
        loop.tick(1.0)
    with pytest.raises(fl.FrictionloopError, match="sweep_s"):
        loop.tick(1.0)


def test_the_set_point_is_the_callers_affair():
    loop = fl.Stepper(BASE.evolve({"setpoint.sweep_s": 0.001}))
    for _ in range(50):
        assert math.isfinite(loop.tick(1.0).force)


def test_time_and_hidden_quantities():
    system = BASE.evolve({"disturbance": fl.Sine(offset_n=0.2, amplitude_n=0.1, frequency_hz=20.0)})
    loop, run = replay(system, 0.05)
    assert loop.time_s == float(run["time"][-1])
    assert loop.force_n == float(run["f_a"][-2])  # at the beginning of the last period, as it says
    loop = fl.Stepper(system)
    assert (loop.time_s, loop.amplitude_um) == (0.0, 0.0)
    assert loop.force_n == loop.measured.force == float(run["f_a"][0])


def test_commands_are_limited_to_what_the_drive_can_do():
    loops = [fl.Stepper(BASE, 3) for _ in range(2)]
    for asked, done in [(-1.0, 0.0), (99.0, 2.5), (0.7, 0.7), (1e300, 2.5)]:
        assert loops[0].tick(asked) == loops[1].tick(done)


def test_a_measurement_is_of_force_alone():
    measured = fl.Stepper(BASE).tick(1.0)
    assert isinstance(measured, fl.Measurement)
    assert (measured.position, measured.speed, measured.load, measured.valid) == (0.0, 0.0, 0.0, 1.0)


def test_steppers_do_not_share_anything():
    one, other = fl.Stepper(BASE, 1), fl.Stepper(BASE, 1)
    for _ in range(40):
        one.tick(2.0)
    first = other.tick(2.0)
    fresh = fl.Stepper(BASE, 1)
    assert fresh.tick(2.0) == first


@pytest.mark.parametrize("command", [math.nan, math.inf, -math.inf, "a", None, True])
def test_a_command_must_be_finite(command):
    loop = fl.Stepper(BASE)
    with pytest.raises(fl.FrictionloopError, match="amplitude_command"):
        loop.tick(command)
    assert loop.time_s == 0.0  # nothing has happened


@pytest.mark.parametrize("system", [BASE, fl.bench()], ids=["paper", "bench"])
def test_after_a_reset_it_is_a_new_one(system):
    loop = fl.Stepper(system, seed=3)
    first = [loop.measured, *(loop.tick(1.0) for _ in range(300))]
    assert [loop.reset(), *(loop.tick(1.0) for _ in range(300))] == first
    other = [loop.reset(4), *(loop.tick(1.0) for _ in range(300))]
    fresh = fl.Stepper(system, seed=4)
    assert other == [fresh.measured, *(fresh.tick(1.0) for _ in range(300))]
    assert loop.reset().force == other[0].force
    assert loop.time_s == 0.0
    with pytest.raises(fl.FrictionloopError, match="seed"):
        loop.reset(-1)


CALM = {"motion.tremor_um": 0.0, "controller.kind": "limit_observer"}
BENCH = fl.bench().evolve({"setpoint": {"kind": "effect"}, **CALM})


def path_of(run):
    """Return the path of a run's finger: where it is at the end of each period."""
    return np.stack([run[name].values for name in ("position", "speed", "load")], axis=1)[1:]


def stroke(start_m, periods, speed_m_s=0.04, load_n=0.5):
    path = np.empty((periods, 3))
    path[:, 0] = start_m + speed_m_s * 2e-4 * np.arange(1, periods + 1)
    path[:, 1:] = speed_m_s, load_n
    return path


def test_the_path_of_a_run_gives_the_run_bit_for_bit():
    run = fl.simulate(BENCH, 0.2, seed=3)
    loop, path = Guided(BENCH, seed=3), path_of(run)
    parts = [loop.advance(part) for part in np.split(path, [25, 26, 90, 500])]
    told = dict(zip(loop.names, np.concatenate(parts, axis=1), strict=True))
    for name in ("f_r", "f_a", "f_m", "u", "a", "position", "limit"):
        np.testing.assert_array_equal(told[name], run[name].values[:-1], err_msg=name)


def test_a_number_changes_without_a_jump_of_the_plate_and_takes_effect():
    loop, same = Guided(BENCH), Guided(BENCH)
    loop.advance(stroke(-0.03, 1000))
    same.advance(stroke(-0.03, 1000))
    assert loop.change(BENCH.evolve({"friction.nominal_n": 1.3}))
    after, beside = (each.advance(stroke(-0.022, 200)) for each in (loop, same))
    a, limit = loop.names.index("a"), loop.names.index("limit")
    assert after[a, 0] == beside[a, 0]
    np.testing.assert_allclose(after[limit] / beside[limit], 1.3 / 0.95)


@pytest.mark.parametrize(
    ("values", "goes_on"),
    [
        ({"controller.model.nominal_n": 1.1}, True),
        ({"sensor.resonance_hz": 200.0}, True),
        ({"setpoint.effect": fl.rendering.LIBRARY["rough"]}, True),
        ({"controller.kind": "pi"}, False),
        ({"controller.rate_hz": 4000.0}, False),
    ],
)
def test_what_makes_another_loop_begins_anew_at_rest(values, goes_on):
    loop = Guided(BENCH)
    loop.advance(stroke(-0.03, 300))
    assert loop.change(BENCH.evolve(values)) is goes_on
    assert (loop.period == 300) is goes_on
    assert np.isfinite(loop.advance(stroke(-0.0276, 300))).all()


def test_a_changed_model_gives_its_own_commands_at_the_clamp():
    """The commands at the ends of the clamp are prepared in period 0; a change has to prepare them again."""
    nothing = {"setpoint.effect": fl.rendering.Constant(level_n=0.0), "friction.nominal_n": 1.3}
    wide = BENCH.evolve({"controller.kind": "pi", "controller.model.table_size": 0, **nothing, **fl.RETUNED})
    wide, changed = wide.evolve({"controller.model.max_amplitude_um": 2.0}), wide
    loop = Guided(wide)
    loop.advance(stroke(-0.03, 200))
    assert loop.change(changed)
    told = dict(zip(loop.names, loop.advance(stroke(-0.0284, 2000)), strict=True))
    assert told["saturated"][-1]
    assert told["a"][-1] == pytest.approx(2.5, rel=1e-3)


def test_several_fingers_under_one_path_are_each_as_if_alone_bit_for_bit():
    people = [BENCH.evolve(finger) for finger in fl.fingers(3, seed=0)]
    changed = [each.evolve({"controller.model.nominal_n": 1.1}) for each in people]
    together, alone = Guided(people, seed=3), [Guided(each, seed=3) for each in people]
    for number, path in enumerate((stroke(-0.03, 300), stroke(-0.0276, 200))):
        if number:
            assert together.change(changed)
            assert all(loop.change(each) for loop, each in zip(alone, changed, strict=True))
        told = together.advance(path)
        for lane, loop in enumerate(alone):
            np.testing.assert_array_equal(told[..., lane], loop.advance(path))


def test_what_cannot_be_moved_is_refused():
    with pytest.raises(fl.FrictionloopError, match=r'motion.kind = "sliding"'):
        Guided(fl.paper())
    loop = Guided(BENCH)
    with pytest.raises(fl.FrictionloopError, match=r'motion.kind = "sliding"'):
        loop.change(fl.paper())
    assert loop.system == BENCH
    with pytest.raises(fl.FrictionloopError, match="path"):
        loop.advance(np.zeros((MOST + 1, 3)))
