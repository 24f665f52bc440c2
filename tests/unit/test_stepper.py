"""The plant alone, one period at a time, is the plant of ``simulate``."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl

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
