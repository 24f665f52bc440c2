"""Gaps in the column of times count in the part in use only."""

from __future__ import annotations

import re

import numpy as np
import pytest

from frictionloop import FrictionloopError, Recording
from frictionloop.recordings.force_channel import read_recording, scaled
from frictionloop.recordings.force_channel import scaled as found

RATE_HZ = 1000.0
ROWS = np.r_[0:300, 500:2000, 2100:2400]
"""Rows that are left of 2400: 200 are missing before 0.5 s, and 100 before 2.1 s."""


@pytest.fixture
def path(tmp_path):
    """A file whose force is the number of the row, in N."""
    written = tmp_path / "gaps.csv"
    np.savetxt(written, np.c_[10.0 + ROWS / RATE_HZ, ROWS], delimiter=",", header="time_s,force", comments="")
    return str(written)


def test_a_part_without_a_gap_is_taken_by_its_times(path):
    taken = read_recording(Recording(path=path, column="force", start_s=10.6, stop_s=11.5), RATE_HZ)
    assert taken.tolist() == list(range(600, 1501))
    early = read_recording(Recording(path=path, column="force", stop_s=10.2), RATE_HZ)
    assert early.tolist() == list(range(201))
    late = read_recording(Recording(path=path, column="force", start_s=12.1), RATE_HZ)
    assert late.tolist() == list(range(2100, 2400))


@pytest.mark.parametrize(
    ("part", "seen", "rows"),
    [
        ({}, "300, first before line 302", (500, 1999)),
        ({"start_s": 10.1, "stop_s": 10.6}, "200, first before line 302", (100, 299)),
        ({"start_s": 11.9}, "100, first before line 1802", (2100, 2399)),
    ],
)
def test_a_gap_in_the_part_is_refused_with_the_longest_part_without(path, part, seen, rows):
    with pytest.raises(FrictionloopError) as refused:
        read_recording(Recording(path=path, column="force", **part), RATE_HZ)
    said = str(refused.value)
    assert f"rows missing in the times: {seen}; " in said
    flags = dict(re.findall(r"--disturbance\.(start_s|stop_s) (\S+)", said))
    taken = read_recording(Recording(path=path, column="force", **{k: float(v) for k, v in flags.items()}), RATE_HZ)
    assert taken.tolist() == list(range(rows[0], rows[1] + 1))


@pytest.mark.parametrize(
    ("part", "said"),
    [
        ({"start_s": 10.4}, "start_s = 10.4 s: must be a time with a row, not from 10.299 to 10.5"),
        ({"start_s": 11.0, "stop_s": 12.05}, "stop_s = 12.05 s: must be a time with a row, not from 11.999 to 12.1"),
        ({"start_s": 13.0}, "start_s = 13 s: must be from 10 to 12.399"),
        ({"start_s": 11.0, "stop_s": 13.0}, "stop_s = 13 s: must be from 10"),
    ],
)
def test_an_end_that_no_row_is_near_is_refused(path, part, said):
    with pytest.raises(FrictionloopError, match=re.escape(said)):
        read_recording(Recording(path=path, column="force", **part), RATE_HZ)


def test_a_blank_behind_a_gap_is_named_by_its_time(path, tmp_path):
    lines = (tmp_path / "gaps.csv").read_text().splitlines()
    lines[301 + 700] = lines[301 + 700].partition(",")[0] + ","  # row 1200
    (tmp_path / "gaps.csv").write_text("\n".join(lines))
    with pytest.raises(FrictionloopError, match=r"no number at 11\.2 s; .*start_s 10\.6 --\S+stop_s 11\.199 "):
        read_recording(Recording(path=path, column="force", start_s=10.6, stop_s=11.5), RATE_HZ)


def test_with_a_rate_given_the_part_is_that_of_the_times_and_a_gap_behind_it_is_not_told(path):
    before = Recording(path=path, column="force", rate_hz=RATE_HZ, start_s=10.1, stop_s=10.25)
    assert scaled(before).force[[0, -1]].tolist() == [100, 250]
    assert found(before).findings == ()
    over = before.model_copy(update={"stop_s": 11.0})
    assert scaled(over).force[[0, -1]].tolist() == [100, 1000]
    (uneven,) = found(over).findings
    assert (uneven.code, uneven.value, uneven.unit) == ("TIMES-UNEVEN", pytest.approx(200.0), "ms")
