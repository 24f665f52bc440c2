"""Rows that are missing are told from a clock that jitters: each gap with its place, jitter as one figure."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.io import savemat

from frictionloop.parameters import Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.steps import SHOWN, uneven_in
from frictionloop.recordings.told import found

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
    times = kept(EVEN_S + jitter * JITTER_S)
    uneven = uneven_in(times, STEP_S, 1e-3)
    assert uneven.missing == ((300, 2), (698, 1))
    steps = np.delete(np.diff(times), [299, 697]) / STEP_S
    assert uneven.jitter == (pytest.approx(np.abs(steps - 1).max()) if jitter else 0.0)


def test_a_pause_is_a_gap_of_the_nearest_number_of_rows():
    assert uneven_in(np.array([0, 1, 2, 102.4, 103.4]), 1.0, 1e-3).missing == ((3, 99),)
    assert uneven_in(np.array([0, 1, 2.6, 3.6]), 1.0, 1e-3).missing == ()


def test_even_times_are_even_and_blank_ones_are_counted():
    assert uneven_in(EVEN_S, STEP_S, 1e-3) is None
    blank = EVEN_S.copy()
    blank[[5, 6]] = np.nan
    assert uneven_in(blank, STEP_S, 1e-3).blank == (5, 6)


def test_gaps_come_first_and_jitter_is_one_figure(tmp_path):
    times = kept(EVEN_S + JITTER_S)
    recording = recorded(tmp_path / "a.csv", times)
    with pytest.raises(FrictionloopError) as refused:
        found(recording)
    said = str(refused.value).partition(": ")[2]
    share = 100 * uneven_in(times, np.median(np.diff(times)), 1e-3).jitter
    missing = "rows missing in the times: 2 before line 302, 1 before line 700"
    assert said.startswith(f"{missing}; steps up to {share:.2g} % off")
    beside = found(recording.model_copy(update={"rate_hz": 1000.0})).uneven
    assert beside.startswith(f"{missing}; steps up to") and "at most 0.00" in beside


def test_many_gaps_are_counted(tmp_path):
    times = np.delete(EVEN_S, range(10, 900, 10))
    with pytest.raises(FrictionloopError) as refused:
        found(recorded(tmp_path / "a.csv", times))
    assert str(refused.value).count("before line") == SHOWN
    assert f"and {89 - SHOWN} more; accepted" in str(refused.value)


def test_a_gap_in_an_array_is_named_by_the_array_of_times(tmp_path):
    times = kept(EVEN_S)
    savemat(tmp_path / "a.mat", {"ft": np.full(times.size, 0.5), "t": times})
    with pytest.raises(FrictionloopError, match="2 before column 't' at index 300, 1 before column 't' at index 698;"):
        found(Recording(path=str(tmp_path / "a.mat"), column="ft"))
