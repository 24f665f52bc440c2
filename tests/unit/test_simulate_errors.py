"""A run that cannot be made is refused in one line before anything runs."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.loop.simulate import check_memory, periods_in

BENCH = fl.bench()
CONSTANT = fl.paper().evolve({"setpoint": fl.Constant(offset_n=0.5)})


def only_line(call, *arguments, **options):
    with pytest.raises(fl.FrictionloopError) as failure:
        call(*arguments, **options)
    assert "\n" not in str(failure.value)
    return str(failure.value)


@pytest.mark.parametrize(
    ("rate_hz", "duration_s", "periods"), [(5000.0, 0.0002, 1), (3000.0, 0.1, 300), (7.0, 3.0, 21)]
)
def test_whole_numbers_of_periods_are_counted_past_rounding(rate_hz, duration_s, periods):
    system = CONSTANT.evolve({"controller.rate_hz": rate_hz})
    assert periods_in(system, duration_s) == periods


@pytest.mark.parametrize("name", ["setpoint", "disturbance"])
def test_past_the_end_of_a_sweep(name):
    system = CONSTANT.evolve({name: fl.LogSweep(sweep_s=2.0)})
    assert f"{name}.sweep_s = 2" in only_line(fl.simulate, system, 3.0)
    assert fl.simulate(system, 2.0).sizes["time"] == 10_000


@pytest.mark.parametrize("name", ["setpoint", "disturbance"])
def test_past_the_end_of_a_recording(tmp_path, name):
    path = tmp_path / "force.csv"
    np.savetxt(path, np.linspace(0.0, 0.1, 101))  # 100 periods and both their ends; the last is held for one more
    system = CONSTANT.evolve({name: fl.Recording(path=str(path), rate_hz=5000.0)})
    assert fl.simulate(system, 0.0202).sizes["time"] == 101
    told = only_line(fl.simulate, system, 0.0204)
    assert told.startswith(f"{path}: duration_s ") and "0.0202 s" in told


def test_memory_is_only_refused_when_it_is_short():
    check_memory(1000, "a little")


def test_numpy_seeds_are_seeds():
    one, other = fl.simulate(CONSTANT, 0.01, seed=np.uint64(7)), fl.simulate(CONSTANT, 0.01, seed=7)
    assert one.identical(other)


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


def test_where_nothing_is_scored_there_is_no_number():
    """A run of a reversal alone: its metrics are NaN in a sweep, and refused of its traces."""
    grid = fl.sweep(BENCH, [{}], 0.02, metrics=["rms_error", "saturation_index", "perceptual_index", "r2_bound"])
    assert all(math.isnan(float(grid[name].squeeze())) for name in grid.data_vars)
    assert "mask" in only_line(fl.rms_error, fl.simulate(BENCH, 0.02))
