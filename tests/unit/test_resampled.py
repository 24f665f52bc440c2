"""Samples at uneven times: refused, or brought to even ones where a map asks for it, and what was done is said."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl


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


@pytest.mark.parametrize(
    ("times", "header", "says"),
    [
        (uneven(), "time_s,f,x", "must be at least 499.6, the mean rate"),
        (uneven()[::-1], "time_s,f,x", "times at row 1 = 'falling'"),
        (1e6 * uneven(), "time,f,x", "unit of 'time' is missing"),
        (uneven(), "a,f,x", "column of times is missing"),
    ],
)
def test_what_cannot_be_resampled_is_one_line(tmp_path, times, header, says):
    hertz = 100.0 if "least" in says else 600.0
    with pytest.raises(fl.FrictionloopError, match=says):
        load(write(tmp_path / "a.csv", times, header=header), hertz)


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
