"""A recording at uneven times is brought to even ones by straight lines, where `resample_hz` asks for it."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.parameters import Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.timestamp_jitter import uneven_in
from frictionloop.recordings.force_channel import read_recording, scaled
from frictionloop.recordings.force_channel import scaled as found

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
    taken = scaled(even)
    assert taken.rate_hz == 100.0 and taken.part.at_s[0] == pytest.approx(5.0, abs=0.5 / 71)
    # A straight line is off by less than (pi f T)^2/2 of a sine, with the longest step T.
    assert np.abs(taken.force - force_n(taken.part.at_s)).max() < 0.1 * (np.pi * HERTZ * 1.3 / 71) ** 2 / 2
    used_s = TIMES_S[np.abs(TIMES_S - 7.0) <= 2.0 + 0.5 / 71]
    mean_hz = 1 / np.diff(used_s).mean()
    (lines,) = found(even).findings
    assert (lines.code, lines.value, lines.limit) == ("RESAMPLED", 100.0, pytest.approx(mean_hz / 10))


def test_a_hole_is_left_out_by_the_part_and_a_blank_is_refused(tmp_path):
    times = np.delete(TIMES_S, slice(300, 400))
    recording = written(tmp_path, times).model_copy(update={"resample_hz": 100.0, "start_s": 12.0})
    assert read_recording(recording, 100.0).size > 500
    force = force_n(times)
    force[900] = np.nan
    written(tmp_path, times, force=force)
    with pytest.raises(fl.FrictionloopError, match="line 902: force is 'nan'; no number at "):
        read_recording(recording, 100.0)


def test_a_run_of_it(tmp_path):
    recording = written(tmp_path).model_copy(update={"resample_hz": 100.0, "start_s": 5.0, "remove_mean": True})
    system = fl.feasible().evolve({"disturbance": recording, "setpoint": fl.Constant(offset_n=0.5)})
    run = fl.simulate(system, 2.0)
    assert float(run.d.std()) == pytest.approx(0.1 / np.sqrt(2), rel=0.02)


# Rows that are missing are told from a clock that jitters: each gap with its place, jitter as one figure.


STEP_S = 1e-3
EVEN_S = STEP_S * np.arange(1000)
JITTER_S = 5e-5 * np.clip(np.random.default_rng(0).normal(size=1000), -2, 2)  # steps are at most 20 % off
LOST = [300, 301, 700]


def kept(times):
    return np.delete(times, LOST)


def recorded(path, times):
    rows = "".join(f"{time:.7f},0.5\n" for time in times)
    path.write_text("time_s,F\n" + rows)
    return Recording(path=str(path), column="F")


@pytest.mark.parametrize("jitter", [0.0, 1.0])
def test_gaps_are_where_rows_are_missing_whatever_the_jitter(jitter):
    assert uneven_in(kept(EVEN_S + jitter * JITTER_S), STEP_S, 1e-3) == ("missing", 300, 3, 0.0)


def test_a_pause_is_a_gap_of_the_nearest_number_of_rows():
    assert uneven_in(np.array([0, 1, 2, 102.4, 103.4]), 1.0, 1e-3)[:3] == ("missing", 3, 99)
    assert uneven_in(np.array([0, 1, 2.6, 3.6]), 1.0, 1e-3) == ("off", 2, 1, pytest.approx(0.6))


def test_even_times_are_even_and_blank_ones_are_counted():
    assert uneven_in(EVEN_S, STEP_S, 1e-3) is None
    blank = EVEN_S.copy()
    blank[[5, 6]] = np.nan
    assert uneven_in(blank, STEP_S, 1e-3)[:3] == ("blank", 5, 2)


def test_gaps_come_before_jitter_and_beside_a_rate_are_told_in_time(tmp_path):
    recording = recorded(tmp_path / "a.csv", kept(EVEN_S + JITTER_S))
    with pytest.raises(FrictionloopError, match=": rows missing in the times: 3, first before line 302; accepted"):
        found(recording)
    (beside,) = found(recording.model_copy(update={"rate_hz": 1000.0})).findings
    assert beside.code == "TIMES-UNEVEN" and beside.value == pytest.approx(3.0, abs=1.0)


# Samples at uneven times: refused, or brought to even ones where a map asks for it, and what was done is said.


def write(path, times, scale=1.0, header="time_s,f,x", wrap=np.inf):
    way = 3.0 * times
    rows = np.column_stack([scale * times, np.sin(2 * np.pi * 5 * times), way if wrap == np.inf else way % wrap])
    np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.9f")
    return path


def uneven(share=0.3, rows=2000, hertz=500.0):
    steps = (1 + share * np.random.default_rng(1).uniform(-1, 1, rows)) / hertz
    return np.cumsum(steps) - steps[0]


MAP = {"channels": {"f_m": {"column": "f", "unit": "N"}, "position": {"column": "x", "unit": "m"}}}


def load(path, hertz, **position):
    tree = {"f_m": MAP["channels"]["f_m"], "position": MAP["channels"]["position"] | position}
    return fl.identify.load(path, tree, resample_hz=hertz)


def test_uneven_times_are_refused_with_what_would_do(tmp_path):
    path = write(tmp_path / "a.csv", uneven())
    with pytest.raises(fl.FrictionloopError, match=r"uneven.* resample_hz = \d+"):
        fl.identify.load(path, MAP["channels"])
    assert "TIMES-UNEVEN" in [each.code for each in fl.identify.channels(path).findings]


@pytest.mark.parametrize(("header", "scale"), [("time_s,f,x", 1.0), ("t [ms],f,x", 1e3), ("time,f,x", 1.0)])
def test_the_signal_is_that_at_even_times(tmp_path, header, scale):
    run = load(write(tmp_path / "a.csv", uneven(), scale, header), 600.0)
    step = np.diff(run.time)
    assert step == pytest.approx(1 / 600) and run.time[-1] == pytest.approx(uneven()[-1], abs=1 / 600)
    # A straight line is off by less than (pi f T)^2/2 of a sine, with the longest step T.
    assert np.abs(run.f_m - np.sin(2 * np.pi * 5 * run.time)).max() < (np.pi * 5 * 1.3 / 500) ** 2 / 2
    assert np.abs(run.position - 3 * run.time).max() < 1e-6
    (brought,) = [each for each in fl.identify.findings_of(run.attrs) if each.code == "RESAMPLED"]
    assert brought.value == 600.0 and run.attrs["rate_from"] == "resample_hz"


def test_a_counter_is_unwrapped_first(tmp_path):
    run = load(write(tmp_path / "a.csv", uneven(), wrap=1.0), 600.0, wrap=1.0)
    assert np.abs(run.position - 3 * run.time).max() < 1e-6


def test_lost_samples_are_bridged_and_counted_a_hole_is_not(tmp_path):
    times = np.arange(3000) / 500
    lost = np.delete(times, [700, 1500, 1501])
    brought = fl.identify.findings_of(load(write(tmp_path / "a.csv", lost), 500.0).attrs)[0]
    assert brought.more["gaps"] == 2 and brought.more["most_apart_ms"] == pytest.approx(6.0)
    with pytest.raises(fl.FrictionloopError, match=r"gap after row 699 = 0.202 s"):
        load(write(tmp_path / "b.csv", np.delete(times, slice(700, 800))), 500.0)


def test_a_project_asks_for_it(tmp_path):
    """A finger that slides at 30 mm/s with mu 1.2, at uneven times; the position is in mm."""
    times = uneven(0.3, 6000)
    phase = times % 4.0
    x, way = 30 * np.minimum(phase, 4 - phase), np.where(phase < 2, 1, -1)
    rows = np.column_stack([times, 0.6 * way, np.full(times.size, 0.5), x])
    rows[:, 1] += 0.01 * np.random.default_rng(0).normal(size=times.size)
    rows[:, 2] += 1e-3 * np.random.default_rng(1).normal(size=times.size)
    np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header="time_s,force_n,load_n,x [mm]", comments="")
    (tmp_path / "lab.toml").write_text(
        """
[[recording]]
kind = "slides"
files = ["a.csv"]
resample_hz = 550
channels.f_m = { column = "force" }
channels.load = { column = "load" }
channels.position = { column = "x" }
"""
    )
    found = fl.identify.bench(tmp_path / "lab.toml")
    assert found.system.friction.nominal_n == pytest.approx(0.6, rel=0.02)
    assert found.parts[0].findings[0].value == 550.0 and found.parts[0].numbers["slides"] > 1
