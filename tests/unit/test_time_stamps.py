"""Times of the clock on the wall in text files: seconds to a recording and to a first look, or named as no time."""

from __future__ import annotations

import numpy as np
import pytest

from frictionloop.identification import channels
from frictionloop.parameters import Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings import stored
from frictionloop.recordings.stamps import is_stamp, seconds_after, stamp_of
from frictionloop.recordings.told import found
from frictionloop.recordings.whole import read_contents

FORCE = 0.3 + 0.1 * np.sin(np.arange(40.0))
BEGIN = np.datetime64("2024-03-05T10:11:12.000500", "ns")
STEP_NS = 100_000  # 10 kHz


def stamped(path, write=str, rows=range(40), head="time,Ft [mN],Fn\n"):
    """Write a force beside stamps; ``write`` gives a stamp its form."""
    lines = [f"{write(str(BEGIN + k * np.timedelta64(STEP_NS, 'ns')))},{1e3 * FORCE[k]:.9g},{k}\n" for k in rows]
    path.write_text(head + "".join(lines))
    return Recording(path=str(path), column="Ft")


FORMS = {
    "plain": str,
    "a space": lambda stamp: stamp.replace("T", " "),
    "Z": lambda stamp: f"{stamp}Z",
    "zone": lambda stamp: f"{stamp}+01:00",
    "quoted": lambda stamp: f'"{stamp}"',
    "fewer digits": lambda stamp: stamp.rstrip("0"),
}


@pytest.mark.parametrize("form", FORMS)
def test_stamps_tell_the_rate_as_seconds_do(tmp_path, form):
    recording = stamped(tmp_path / "a.csv", FORMS[form])
    read = found(recording)
    assert (read.rate_hz, read.rate_by, read.samples) == (1e4, "'time'", 40)
    seen = channels(recording.path)
    assert seen.rate_hz == pytest.approx(1e4, rel=1e-9) and seen.even
    hour = 9 if form == "zone" else 10
    assert seen.date == f"2024-03-05T{hour:02}:11:12"
    assert [(each.name, each.unit, each.missing) for each in seen.channels] == [
        ("time", "s", 0),
        ("Ft", "mN", 0),
        ("Fn", "", 0),
    ]


def test_stamps_are_found_below_titles_and_units_and_without_a_name(tmp_path):
    titled = stamped(tmp_path / "a.csv", head="Recorder 5\noperator,JD\ntaken at,Ft,k\n-,mN,-\n")
    assert found(titled).rate_hz == 1e4 and found(titled).unit == "mN"
    bare = stamped(tmp_path / "b.csv", head="").model_copy(update={"column": "1", "unit": "mN"})
    assert found(bare).rate_hz == 1e4
    assert channels(titled.path).rate_hz == channels(bare.path).rate_hz == pytest.approx(1e4)


def test_lost_rows_are_refused_and_told_beside_a_rate(tmp_path):
    rows = [k for k in range(40) if k not in (10, 11, 30)]
    recording = stamped(tmp_path / "a.csv", rows=rows)
    with pytest.raises(FrictionloopError, match="rows missing in the times: 2 before line 12, 1 before line 30;"):
        found(recording)
    assert (
        "2 before line 12, 1 before line 30; rows are taken"
        in found(recording.model_copy(update={"rate_hz": 1e4})).uneven
    )
    assert channels(recording.path).gaps == ((9, 2), (27, 1))


@pytest.mark.parametrize("wrong", ["05.03.2024 10:11:12", "2024-13-05T10:11:12", "10:11:12.5"])
def test_what_is_no_time_is_named_with_what_would_be(tmp_path, wrong):
    recording = stamped(tmp_path / "a.csv", lambda stamp: wrong)
    with pytest.raises(FrictionloopError) as refused:
        found(recording)
    assert f"line 2: time is '{wrong}' (and 39 more); accepted: a number, or a time as 2024-03-05T" in str(
        refused.value
    )
    assert (
        found(recording.model_copy(update={"rate_hz": 1e4})).uneven == f"times are not read: line 2: time is '{wrong}'"
    )
    seen = channels(recording.path)
    assert [each.name for each in seen.channels] == ["Ft", "Fn"]
    left = [each.where.channel for each in seen.findings if each.code == "LEFT-OUT"]
    assert left == ["time"]


def test_one_wrong_stamp_is_named(tmp_path):
    recording = stamped(tmp_path / "a.csv", lambda stamp: "-" if stamp.endswith("2600000") else stamp)
    with pytest.raises(FrictionloopError, match="line 23: time is '-'; accepted: a number, or a time as"):
        found(recording)
    assert channels(recording.path).channels[0].missing == 1


def test_stamps_of_a_large_file_count_from_its_first_row(tmp_path, monkeypatch):
    recording = stamped(tmp_path / "a.csv")
    whole = [np.asarray(each.samples) for each in read_contents(recording.path).channels]
    monkeypatch.setattr(stored, "BLOCK", 8)
    monkeypatch.setattr(stored, "LARGE_BYTES", 100)
    blocks = read_contents(recording.path).channels
    assert isinstance(blocks[0].samples, stored.Stored)
    np.testing.assert_array_equal([np.asarray(each.samples) for each in blocks], whole)
    np.testing.assert_allclose(whole[0], np.arange(40) / 1e4, rtol=0, atol=1e-12)


def test_zones_and_numbers():
    assert stamp_of("2024-03-05T10:11:12-01:30") == np.datetime64("2024-03-05T11:41:12")
    assert stamp_of("2024-03-05 10:11:12,5 +0100") == np.datetime64("2024-03-05T09:11:12.5")
    assert not any(map(is_stamp, ("2024", "20240305", "now", "NaT", "", "1.5")))
    np.testing.assert_array_equal(seconds_after(BEGIN, ["x", str(BEGIN)]), [np.nan, 0.0])
