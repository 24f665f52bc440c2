"""What stands above the numbers of a text file is read alike by a signal of the loop and by identification."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.identification import channels
from frictionloop.parameters import Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings import contents
from frictionloop.recordings.contents import told_rate
from frictionloop.recordings.file_opening import _read, read_contents
from frictionloop.recordings.force_channel import scaled as found
from frictionloop.recordings.text_numbers import is_stamp, seconds_after, stamp_of

ROWS = "".join(f"{k / 10:.1f}\n" for k in range(1, 9))
PAIRS = "".join(f"{k / 10:.1f},{k}\n" for k in range(1, 9))


def text(folder: Path, content: str) -> Path:
    path = folder / "force.csv"
    path.write_text(content)
    return path


@pytest.mark.parametrize(
    "above",
    [
        "# rate_hz: 1000\n",
        "# fs = 1000\n# index finger\n",
        "Sampling rate: 1 kHz\nDate: 2020-01-02\n\n",
        "# sampling rate 1000 Hz\n",
        "% dt_ms: 1\n",
        "Sample interval;1 ms\n",
        '"Sample rate","1000"\n',
    ],
)
@pytest.mark.parametrize("names", ["force_n\n", "force [N]\n"])
def test_both_readers_take_the_same_rate_from_the_same_line(tmp_path, above, names):
    path = text(tmp_path, above + names + ROWS)
    one = found(Recording(path=str(path), column="force"))
    assert one.rate_hz == pytest.approx(1000.0)
    assert one.part.by.endswith("in line 1")
    (by,) = read_contents(path).channels[0].rates_hz.items()
    assert by == (one.part.by, pytest.approx(1000.0))
    assert [each.name for each in read_contents(path).channels] == ["force"]
    assert [each.unit for each in read_contents(path).channels] == ["N"]


def test_a_unit_above_is_that_of_the_only_signal_and_of_the_one_it_names(tmp_path):
    path = text(tmp_path, "# fs: 1000\n# unit: mN\nforce\n" + ROWS)
    assert found(Recording(path=str(path), column="force")).force.max() == pytest.approx(0.8e-3)
    assert [each.unit for each in read_contents(path).channels] == ["mN"]
    path = text(tmp_path, "fs,1000\nforce unit,mN\nforce,load\n" + PAIRS)
    assert found(Recording(path=str(path), column="force")).force.max() == pytest.approx(0.8e-3)
    assert [(each.name, each.unit) for each in read_contents(path).channels] == [("force", "mN"), ("load", None)]


def test_a_unit_of_one_of_several_columns_is_not_passed_over(tmp_path):
    recording = Recording(path=str(text(tmp_path, "fs,1000\nUnit,mN\nforce,load\n" + PAIRS)), column="force")
    with pytest.raises(fl.FrictionloopError, match="line 2: 'Unit' is mN, of one of 2 columns; accepted"):
        found(recording)
    assert found(recording.model_copy(update={"unit": "mN"})).force.max() == pytest.approx(0.8e-3)


def test_settings_are_no_names(tmp_path):
    path = text(tmp_path, "Sample rate,1000\nUnit,mN\n" + PAIRS)
    assert [each.name for each in read_contents(path).channels] == ["0", "1"]
    assert found(Recording(path=str(path), column="0", unit="mN")).channel.name == "0"


@pytest.mark.parametrize(
    ("name", "value", "hertz"),
    [
        ("fs", "1 kHz", 1000.0),
        ("fs_khz", 2.0, 2000.0),
        ("Sample rate (Hz)", "250", 250.0),
        ("rate", b"100", 100.0),
        ("interval", "0,002 s", 500.0),
        ("interval", "2 ms", 500.0),
        ("dt_us", 100, 1e4),
        ("rate", "10,000", None),  # ten or ten thousand
        ("rate", "1 s", None),
        ("dt", "1 Hz", None),
        ("rate", "fast", None),
        ("rate", -1.0, None),
        ("rate", "nan", None),
        ("strain rate", "3", None),
    ],
)
def test_a_rate_is_a_name_with_a_number_and_a_unit_that_fits(name, value, hertz):
    assert told_rate(name, value) == (None if hertz is None else pytest.approx(hertz))


@pytest.mark.parametrize(
    ("unit", "newtons"), [("gf", 9.80665e-3), ("kgf", 9.80665), ("cN", 0.01), ("grams-force", 9.80665e-3)]
)
def test_a_force_in_grams_is_scaled_and_a_mass_is_refused_with_the_scale(tmp_path, unit, newtons):
    path = text(tmp_path, f"# fs: 1000\nforce [{unit}]\n" + ROWS)
    assert found(Recording(path=str(path), column="force")).force.max() == pytest.approx(0.8 * newtons)
    path = text(tmp_path, "# fs: 1000\nforce [g]\n" + ROWS)
    with pytest.raises(fl.FrictionloopError, match=r'N per g, such as 0\.00980665, or unit = "gf"'):
        found(Recording(path=str(path), column="force"))
    assert found(Recording(path=str(path), column="force", unit="gf")).force.max() == pytest.approx(0.8 * 9.80665e-3)


def test_rows_that_are_missing_or_doubled_are_told_where_a_rate_stands_for_the_times(tmp_path):
    times = [0, 2, 4, 8, 10, 10, 14, 16]
    rows = "".join(f"{t},{t / 10}\n" for t in times)
    path = text(tmp_path, "t [ms],force [N]\n" + rows)
    with pytest.raises(fl.FrictionloopError, match="times: 2, first before line 5;"):
        found(Recording(path=str(path), column="force"))
    (uneven,) = found(Recording(path=str(path), column="force", rate_hz=500.0)).findings
    assert (uneven.code, uneven.value) == ("TIMES-UNEVEN", pytest.approx(2.0))
    path = text(tmp_path, "t [ms],force [N]\n" + "".join(f"{2 * k},1\n" for k in range(8)))
    assert found(Recording(path=str(path), column="force", rate_hz=500.0)).findings == ()


def test_a_decimal_comma_below_names_and_units_is_found_and_told(tmp_path):
    path = text(tmp_path, "Zeit;Kraft\nms;gf\n0,0;55,7\n2,0;54,4\n")
    one = found(Recording(path=str(path), column="Kraft"))
    assert (one.unit, one.unit_by, one.force.size, one.rate_hz, one.part.by) == ("gf", "file", 2, 500.0, "'Zeit'")
    assert [(each.code, each.value) for each in one.findings] == [("TAKEN-FOR", "comma")]


# Times of the clock on the wall in text files: seconds to a recording and to a first look, or named as no time.


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
    assert (read.rate_hz, read.part.by, read.force.size) == (1e4, "'time'", 40)
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
    with pytest.raises(FrictionloopError, match="rows missing in the times: 3, first before line 12;"):
        found(recording)
    (uneven,) = found(recording.model_copy(update={"rate_hz": 1e4})).findings
    assert (uneven.code, uneven.value) == ("TIMES-UNEVEN", pytest.approx(0.3))
    assert channels(recording.path).gaps == ((9, 2), (27, 1))


@pytest.mark.parametrize("first", ["10:11:12.5", "9:59:59.99875", "23:59:59.999", "23:59:59,998"])
def test_times_of_the_clock_without_a_date_tell_the_rate_through_midnight(tmp_path, first):
    """A date is not made up for them."""
    mark = ";" if "," in first else ","
    begin = np.datetime64("1970-01-01T" + f"{chr(48) * (first[1] == chr(58))}{first}".replace(",", "."), "ns")
    path, rows = tmp_path / "a.csv", []
    for k, force in enumerate(FORCE):
        clock = str(begin + k * np.timedelta64(STEP_NS, "ns")).partition("T")[2].removeprefix("0")
        rows.append(f"{clock}{mark}{force:.9f}".replace(".", "," if mark == ";" else "."))
    path.write_text("\n".join([f"time{mark}Ft [N]", *rows]))
    read = found(Recording(path=str(path), column="Ft"))
    assert (read.rate_hz, read.part.by) == (pytest.approx(1e4), "'time'")
    np.testing.assert_allclose(read.force, FORCE, atol=1e-9)
    seen = channels(path)
    assert seen.even and not seen.channels[0].missing and not seen.date.startswith("1970")


@pytest.mark.parametrize("wrong", ["05.03.2024 10:11:12", "2024-13-05T10:11:12", "25:11:12.5", "10:11"])
def test_what_is_no_time_is_named_with_what_would_be(tmp_path, wrong):
    recording = stamped(tmp_path / "a.csv", lambda stamp: wrong)
    with pytest.raises(FrictionloopError) as refused:
        found(recording)
    assert f"line 2: time is '{wrong}' (and 39 more); accepted: a number, or a time as 2024-03-05T" in str(
        refused.value
    )
    seen = channels(recording.path)
    for findings in (found(recording.model_copy(update={"rate_hz": 1e4})).findings, seen.findings):
        assert [each.where.channel for each in findings if each.code == "LEFT-OUT"] == ["time"]


def test_one_wrong_stamp_is_named(tmp_path):
    recording = stamped(tmp_path / "a.csv", lambda stamp: "-" if stamp.endswith("2600000") else stamp)
    with pytest.raises(FrictionloopError, match="line 23: time is '-'; accepted: a number, or a time as"):
        found(recording)
    assert channels(recording.path).channels[0].missing == 1


def test_stamps_of_a_large_file_count_from_its_first_row(tmp_path, monkeypatch):
    recording = stamped(tmp_path / "a.csv")
    at_once = [np.asarray(each.samples) for each in read_contents(recording.path).channels]
    monkeypatch.setattr(contents, "BLOCK", 8)
    monkeypatch.setattr(contents, "LARGE_BYTES", 100)
    _read.cache_clear()
    blocks = read_contents(recording.path).channels
    assert isinstance(blocks[0].samples, contents.Stored)
    np.testing.assert_array_equal([np.asarray(each.samples) for each in blocks], at_once)
    np.testing.assert_allclose(at_once[0], np.arange(40) / 1e4, rtol=0, atol=1e-12)


def test_zones_and_numbers():
    assert stamp_of("2024-03-05T10:11:12-01:30") == np.datetime64("2024-03-05T11:41:12")
    assert stamp_of("2024-03-05 10:11:12,5 +0100") == np.datetime64("2024-03-05T09:11:12.5")
    assert not any(map(is_stamp, ("2024", "20240305", "now", "NaT", "", "1.5", "10:11", "1:2:3")))
    np.testing.assert_array_equal(seconds_after(BEGIN, ["x", str(BEGIN)]), [np.nan, 0.0])
