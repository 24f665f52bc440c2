"""A recording at uneven times is brought to even ones by straight lines, where `resample_hz` asks for it."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.recordings.read import read_recording, scaled
from frictionloop.recordings.told import found

STEPS_S = (1 + 0.3 * np.random.default_rng(1).uniform(-1, 1, 1500)) / 71.0
TIMES_S = 3.0 + np.cumsum(STEPS_S) - STEPS_S[0]
HERTZ = 2.0


def force_n(times_s):
    return 0.5 + 0.1 * np.sin(2 * np.pi * HERTZ * times_s)


def written(folder, times=TIMES_S, name="time_s", force=None, scale=1.0):
    columns = np.c_[scale * times, force_n(times) if force is None else force]
    np.savetxt(folder / "f.csv", columns, delimiter=",", header=f"{name},force", comments="", fmt="%.9f")
    return fl.Recording(path=str(folder / "f.csv"), column="force")


@pytest.mark.parametrize(("name", "scale"), [("time_s", 1.0), ("t [ms]", 1e3), ("Time", 1.0)])
def test_the_force_is_that_at_even_times(tmp_path, name, scale):
    recording = written(tmp_path, name=name, scale=scale)
    with pytest.raises(fl.FrictionloopError, match=r"steps up to \d+ % off.*--disturbance\.resample_hz 71 \(or --set"):
        read_recording(recording, 100.0)
    even = recording.model_copy(update={"resample_hz": 100.0, "start_s": 5.0, "stop_s": 9.0})
    taken = scaled(even, "N")
    assert taken.rate_hz == 100.0 and taken.part.at_s[0] == pytest.approx(5.0, abs=0.5 / 71)
    # A straight line is off by less than (pi f T)^2/2 of a sine, with the longest step T.
    assert np.abs(taken.force - force_n(taken.part.at_s)).max() < 0.1 * (np.pi * HERTZ * 1.3 / 71) ** 2 / 2
    assert found(even).rate_by.startswith("straight lines between 2") and found(even).begins_s
    used_s = TIMES_S[np.abs(TIMES_S - 7.0) <= 2.0 + 0.5 / 71]
    mean_hz = 1 / np.diff(used_s).mean()
    assert f"straight lines: {mean_hz / 10:.3g} Hz loses up to 5 %" in found(even).uneven


@pytest.mark.parametrize(
    ("times", "name", "more", "says"),
    [
        (TIMES_S, "time_s", {"resample_hz": 50.0}, "resample_hz = 50 Hz: must be at least 7"),
        (np.delete(TIMES_S, slice(300, 400)), "time_s", {}, "gap after line 301.* = 1.4 s"),
        (TIMES_S[::-1], "time_s", {}, "usual step of|falling"),
        (1e6 * TIMES_S, "time", {}, "unit of 'time' is missing"),
        (TIMES_S, "a", {}, "column of times is missing"),
    ],
)
def test_what_cannot_be_brought_to_even_times_is_one_line(tmp_path, times, name, more, says):
    recording = written(tmp_path, times, name).model_copy(update={"resample_hz": 100.0, **more})
    with pytest.raises(fl.FrictionloopError, match=says):
        read_recording(recording, 100.0)


def test_a_hole_is_left_out_by_the_part_and_a_blank_is_refused(tmp_path):
    times = np.delete(TIMES_S, slice(300, 400))
    recording = written(tmp_path, times).model_copy(update={"resample_hz": 100.0, "start_s": 12.0})
    assert read_recording(recording, 100.0).size > 500
    force = force_n(times)
    force[900] = np.nan
    written(tmp_path, times, force=force)
    with pytest.raises(fl.FrictionloopError, match="line 902: force is 'nan'; no number at "):
        read_recording(recording, 100.0)


def test_two_rates_are_refused():
    with pytest.raises(fl.FrictionloopError, match="rate_hz and resample_hz"):
        fl.feasible().evolve({"disturbance": {"kind": "recording", "path": "a", "rate_hz": 1.0, "resample_hz": 1.0}})


def test_a_run_of_it(tmp_path):
    recording = written(tmp_path).model_copy(update={"resample_hz": 100.0, "start_s": 5.0, "remove_mean": True})
    system = fl.feasible().evolve({"disturbance": recording, "setpoint": fl.Constant(offset_n=0.5)})
    run = fl.simulate(system, 2.0)
    assert float(run.d.std()) == pytest.approx(0.1 / np.sqrt(2), rel=0.02)
