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


@pytest.mark.parametrize(
    "use", [fl.simulate, fl.Stepper, fl.linearise, fl.kp_limit, fl.reachable, fl.to_toml, lambda s: fl.sweep(s, {})]
)
@pytest.mark.parametrize("given", ["paper", None, fl.Friction()], ids=repr)
def test_a_system_is_a_system(use, given):
    with pytest.raises(fl.FrictionloopError, match=r"^system = .*: .*System") as failure:
        use(given)
    assert "\n" not in str(failure.value)
