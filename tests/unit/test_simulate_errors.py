"""A run that cannot be made is refused in one line before anything runs."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.loop.simulate import check_memory, periods_in

CONSTANT = fl.paper().evolve({"setpoint": fl.Constant(offset_n=0.5)})


def complaint(system, *arguments, **options):
    with pytest.raises(fl.FrictionloopError) as failure:
        fl.simulate(system, *arguments, **options)
    assert "\n" not in str(failure.value)
    return str(failure.value)


@pytest.mark.parametrize("duration_s", [0.0, -1.0, math.nan, math.inf, -math.inf, "10", True])
def test_a_duration_is_positive(duration_s):
    given = f"{duration_s:g}" if isinstance(duration_s, float) else repr(duration_s)
    assert complaint(CONSTANT, duration_s).startswith(f"duration_s = {given} s: ")


def test_a_duration_that_is_missing_is_told():
    assert complaint(CONSTANT, None) == "duration_s is missing: a positive number, in s"


@pytest.mark.parametrize(("duration_s", "nearest"), [(0.00033, "0.0004"), (1.00005, "1.0"), (1e-9, "0.0002")])
def test_a_duration_is_a_whole_number_of_periods(duration_s, nearest):
    told = complaint(CONSTANT, duration_s)
    assert "5000 Hz" in told
    assert f"as {nearest}" in told


@pytest.mark.parametrize(
    ("rate_hz", "duration_s", "periods"), [(5000.0, 0.0002, 1), (3000.0, 0.1, 300), (7.0, 3.0, 21)]
)
def test_whole_numbers_of_periods_are_counted_past_rounding(rate_hz, duration_s, periods):
    system = CONSTANT.evolve({"controller.rate_hz": rate_hz})
    assert periods_in(system, duration_s) == periods


def test_a_rate_that_does_not_divide_the_duration():
    assert "rate_hz = 5001 Hz" in complaint(CONSTANT.evolve({"controller.rate_hz": 5001.0}), 0.5)


@pytest.mark.parametrize("name", ["setpoint", "disturbance"])
def test_past_the_end_of_a_sweep(name):
    system = CONSTANT.evolve({name: fl.LogSweep(sweep_s=2.0)})
    assert f"{name}.sweep_s = 2" in complaint(system, 3.0)
    assert fl.simulate(system, 2.0).sizes["time"] == 10_000


@pytest.mark.parametrize("name", ["setpoint", "disturbance"])
def test_past_the_end_of_a_recording(tmp_path, name):
    path = tmp_path / "force.csv"
    np.savetxt(path, np.linspace(0.0, 0.1, 101))  # 100 periods and both their ends; the last is held for one more
    system = CONSTANT.evolve({name: fl.Recording(path=str(path), rate_hz=5000.0)})
    assert fl.simulate(system, 0.0202).sizes["time"] == 101
    told = complaint(system, 0.0204)
    assert told.startswith(f"{path}: duration_s ") and "0.0202 s" in told


def test_a_missing_recording(tmp_path):
    system = CONSTANT.evolve({"disturbance": fl.Recording(path=str(tmp_path / "none.csv"), rate_hz=5000.0)})
    assert "none.csv" in complaint(system, 0.02)


def test_too_long_for_the_memory_says_how_much():
    # 1e7 s * 5000 Hz periods of 7 traces of 8 bytes, and as much again to arrange them: 5600 GB.
    told = complaint(CONSTANT, 1e7)
    assert "5600.0 GB" in told
    assert "duration_s" in complaint(CONSTANT, 1e308)


def test_memory_is_only_refused_when_it_is_short():
    check_memory(1000, "a little")


@pytest.mark.parametrize("seed", [-1, 2**64, 1.5, "1", None, True])
def test_a_bad_seed(seed):
    assert complaint(CONSTANT, 0.01, seed=seed).startswith(f"seed = {seed!r}: ")


def test_numpy_seeds_are_seeds():
    one, other = fl.simulate(CONSTANT, 0.01, seed=np.uint64(7)), fl.simulate(CONSTANT, 0.01, seed=7)
    assert one.identical(other)


def test_a_plate_faster_than_the_control_rate_can_resolve():
    assert "plate.cutoff_hz = 100000 Hz: at most 4900 Hz" in complaint(CONSTANT.evolve({"plate.cutoff_hz": 1e5}), 0.01)


@pytest.mark.parametrize(
    ("disturbance", "told"),
    [
        (fl.Sine(frequency_hz=2501.0), "disturbance.frequency_hz = 2501 Hz: "),
        (fl.LogSweep(stop_hz=3000.0), "disturbance.start_hz and stop_hz = 3000 Hz: "),
        (fl.LogSweep(start_hz=3000.0), "disturbance.start_hz and stop_hz = 3000 Hz: "),
    ],
)
def test_a_disturbance_faster_than_the_control_rate_can_resolve(disturbance, told):
    assert complaint(CONSTANT.evolve({"disturbance": disturbance}), 0.01).startswith(told)
    with pytest.raises(fl.FrictionloopError, match="disturbance"):
        fl.Stepper(CONSTANT.evolve({"disturbance": disturbance}))
    # The set-point is only ever used at the samples.
    assert fl.simulate(CONSTANT.evolve({"setpoint": disturbance}), 0.01).sizes["time"] == 50


# Bad input to a bench: one line that names the parameter, what was given and what would be accepted.


BENCH = fl.bench()
VALUES = [
    ({"plate.q": 0.0}, "plate.q = 0.0: must be greater than 0"),
    ({"sensor.q": -20.0}, "sensor.q = -20.0: must be greater than 0"),
    ({"sensor.resonance_hz": 0.0}, "sensor.resonance_hz = 0.0 Hz: must be greater than 0"),
    ({"sensor.adc_bits": 0}, "sensor.adc_bits = 0: must be greater than or equal to 1"),
    ({"sensor.adc_bits": 16.5}, "sensor.adc_bits = 16.5"),
    ({"motion.load_n": -0.5}, "motion.load_n = -0.5 N: must be greater than 0"),
    ({"motion.load_drift": 0.5}, "motion.load_drift = 0.5: must be less than 0.5"),
    ({"motion.reversal_s": 10.0}, "motion: reversal_s = 10 s at 20 mm/s: "),
    ({"motion.contact_s": 0.05}, "motion: contact_s = 0.05 s: must be 0 or at least 0.1"),
    ({"motion.kind": "sliding"}, 'friction.kind = "finger": needs motion.kind = "strokes"'),
    ({"friction": fl.Friction(), "motion": fl.Sliding()}, 'finger.kind = "skin": needs motion.kind = "strokes"'),
    ({"finger.slip_length_um": "coulomb"}, "finger.slip_length_um = 'coulomb'"),
    ({"finger.stiffness_n_m": 0.0}, "finger.stiffness_n_m = 0.0 N/m: must be greater than 0"),
    ({"friction.moist_loss": 1.0}, "friction.moist_loss = 1.0: must be less than 1"),
    ({"controller.lost_ticks": 1.0}, "controller.lost_ticks = 1.0: must be less than 1"),
    ({"sensor.range_n": 0.8}, "sensor.range_n = 0.8 N: controller.model.nominal_n is 0.95 N"),
    ({"setpoint.offset_n": 2.45}, "sensor.range_n = 2.5 N: "),
    ({"setpoint": fl.Steps(times_s=(0.0, 0.1), levels_n=(0.5, -3.0))}, "sensor.range_n = 2.5 N: "),
]
RUNS = [
    ({"motion.speed_mm_s": 600.0}, "motion.speed_mm_s = 600 mm/s: above touch.position.fastest_mm_s = 500"),
    ({"motion.stroke_mm": 300.0}, "motion.stroke_mm = 300 mm: above touch.load.length_mm = 255"),
    ({"controller.rate_hz": 100.0}, "controller.rate_hz = 100 Hz: must be at least"),
    ({"disturbance": fl.Sine(amplitude_n=0.1, frequency_hz=3e3)}, "disturbance.frequency_hz = 3000 Hz: "),
]


def only_line(call, *arguments, **options):
    with pytest.raises(fl.FrictionloopError) as failure:
        call(*arguments, **options)
    assert "\n" not in str(failure.value)
    return str(failure.value)


@pytest.mark.parametrize(("overrides", "line"), VALUES, ids=str)
def test_a_bad_value_is_one_line(overrides, line):
    assert line in only_line(BENCH.evolve, overrides)


@pytest.mark.parametrize("call", [fl.simulate, fl.plain_stroke, lambda s, **_: fl.sweep(s, [{}], 0.01), fl.Stepper])
@pytest.mark.parametrize(("overrides", "line"), RUNS, ids=str)
def test_what_cannot_run_is_one_line(call, overrides, line):
    system = BENCH.evolve(overrides)
    assert line in only_line(call, system, **({} if call is fl.Stepper else {"duration_s": 0.1}))


GRIDS = {
    "turns longer than strokes": ({"motion.speed_mm_s": [10.0, 100.0], "motion.reversal_s": [0.1, 2.0]}, "reversal_s"),
    "contacts shorter than landings": ({"motion.contact_s": [0.2, 1.0], "motion.landing_s": [0.05, 0.3]}, "contact_s"),
    "set-points out of range": (
        {"setpoint.offset_n": [0.5, 2.0], "setpoint.amplitude_n": [0.1, 1.0]},
        "sensor.range_n = 2.5 N",
    ),
    "a sensor that does not follow": (
        {"motion.speed_mm_s": [20.0, 200.0], "touch.position.fastest_mm_s": [300.0, 100.0]},
        "touch.position.fastest_mm_s = 100",
    ),
    "a short plate": ({"motion.stroke_mm": [20.0, 90.0], "touch.load.length_mm": [100.0, 70.0]}, "length_mm = 70"),
    "a narrow converter": (
        {"sensor.range_n": [1.0, 2.5], "controller.model.nominal_n": [0.9, 1.2]},
        "sensor.range_n = 1 N: controller.model.nominal_n is 1.2 N",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", GRIDS)
def test_values_of_a_sweep_are_checked_together(name):
    """Each is fine beside the other values of the bench; two together are not."""
    points, line = GRIDS[name]
    for path, values in points.items():
        for value in values:
            if path not in ("motion.reversal_s", "motion.landing_s"):
                assert fl.simulate(BENCH.evolve({path: value}), 0.001).sizes["time"] == 5
    assert line in only_line(fl.sweep, BENCH, points, 0.01)


@pytest.mark.parametrize("metric", ["rise_63_s", "rise_10_90_s", "fall_63_s", "fall_10_90_s"])
def test_times_of_steps_need_steps(metric):
    line = only_line(fl.sweep, BENCH, {"controller.kp": [1.0]}, 0.01, metrics=[metric])
    assert line.startswith(f"metric {metric}: ") and "setpoint.kind 'steps'" in line
    assert "setpoint.kind 'steps'" in only_line(fl.step_times, fl.simulate(BENCH, 0.01))


MOVEMENTS = [
    (fl.Movement(0.0, 0.02, -0.5), "load_n"),
    (fl.Movement(math.nan, 0.02, 0.5), "motion = "),
    (fl.Movement(0.0, math.inf, 0.5), "motion = "),
]


@pytest.mark.parametrize(("motion", "line"), MOVEMENTS, ids=str)
def test_a_bad_movement_is_one_line_and_nothing_happens(motion, line):
    loop = fl.Stepper(BENCH)
    assert line in only_line(loop.tick, 1.0, motion)
    assert loop.time_s == 0.0
    assert loop.tick(1.0) == fl.Stepper(BENCH).tick(1.0)


def test_a_plant_without_motion_takes_none():
    still = BENCH.evolve({"friction": fl.Friction(), "finger": fl.RigidFinger(), "motion": fl.Sliding()})
    assert 'motion.kind "strokes"' in only_line(fl.Stepper(still).tick, 1.0, fl.Movement(0.0, 0.02, 0.5))


@pytest.mark.parametrize("amplitude_um", [math.nan, math.inf, "a", None])
def test_a_plain_stroke_needs_a_number(amplitude_um):
    assert "amplitude_um" in only_line(fl.plain_stroke, BENCH, amplitude_um, 0.01)


def test_a_force_that_no_amplitude_gives_has_no_plain_stroke():
    run = fl.simulate(BENCH.evolve({**fl.RETUNED, "motion.start": 0.1}), 0.1)
    assert "mean force = 5.58 N: " in only_line(fl.plain_like, run.assign(f_a=run["f_a"] + 5.0))
    assert "'system'" in only_line(fl.plain_like, run.drop_attrs())


def test_where_nothing_is_scored_there_is_no_number():
    """A run of a reversal alone: its metrics are NaN in a sweep, and refused of its traces."""
    grid = fl.sweep(BENCH, [{}], 0.02, metrics=["rms_error", "saturation_index", "perceptual_index", "r2_bound"])
    assert all(math.isnan(float(grid[name].squeeze())) for name in grid.data_vars)
    assert "mask" in only_line(fl.rms_error, fl.simulate(BENCH, 0.02))


# What is no run, and what are no points, is refused in one line.
