"""What stands above the numbers of a text file is read alike by a signal of the loop and by identification."""

from pathlib import Path

import pytest

import frictionloop as fl
from frictionloop.parameters import Recording
from frictionloop.recordings.contents import told_rate
from frictionloop.recordings.told import found
from frictionloop.recordings.whole import read_contents

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
    assert one.rate_by.endswith("in line 1")
    (by,) = read_contents(path).rates_hz.items()
    assert by == (one.rate_by, pytest.approx(1000.0))
    assert [each.name for each in read_contents(path).channels] == ["force"]
    assert [each.unit for each in read_contents(path).channels] == ["N"]


def test_two_rates_are_in_doubt_and_times_contradict_a_rate(tmp_path):
    path = text(tmp_path, "# fs: 500\n# dt_ms: 1\nforce_n\n" + ROWS)
    with pytest.raises(fl.FrictionloopError, match="in doubt: 'fs' in line 1 says 500 Hz, 'dt_ms' in line 2 says 1000"):
        found(Recording(path=str(path), column="force"))
    path = text(tmp_path, "# fs: 500\nt_s,force_n\n" + "".join(f"{k / 1000},{k}\n" for k in range(9)))
    with pytest.raises(fl.FrictionloopError, match="1000 Hz by 't_s', 500 Hz by 'fs' in line 1"):
        found(Recording(path=str(path), column="force"))


def test_a_unit_above_is_that_of_the_only_signal_and_of_the_one_it_names(tmp_path):
    path = text(tmp_path, "# fs: 1000\n# unit: mN\nforce\n" + ROWS)
    assert found(Recording(path=str(path), column="force")).highest_n == pytest.approx(0.8e-3)
    assert [each.unit for each in read_contents(path).channels] == ["mN"]
    path = text(tmp_path, "fs,1000\nforce unit,mN\nforce,load\n" + PAIRS)
    assert found(Recording(path=str(path), column="force")).highest_n == pytest.approx(0.8e-3)
    assert [(each.name, each.unit) for each in read_contents(path).channels] == [("force", "mN"), ("load", None)]


def test_a_unit_of_one_of_several_columns_is_not_passed_over(tmp_path):
    recording = Recording(path=str(text(tmp_path, "fs,1000\nUnit,mN\nforce,load\n" + PAIRS)), column="force")
    with pytest.raises(fl.FrictionloopError, match="line 2: 'Unit' is mN, of one of 2 columns; accepted"):
        found(recording)
    assert found(recording.model_copy(update={"unit": "mN"})).highest_n == pytest.approx(0.8e-3)


def test_settings_are_no_names(tmp_path):
    path = text(tmp_path, "Sample rate,1000\nUnit,mN\n" + PAIRS)
    assert [each.name for each in read_contents(path).channels] == ["0", "1"]
    assert found(Recording(path=str(path), column="0", unit="mN")).column == "0"


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
    assert found(Recording(path=str(path), column="force")).highest_n == pytest.approx(0.8 * newtons)
    path = text(tmp_path, "# fs: 1000\nforce [g]\n" + ROWS)
    with pytest.raises(fl.FrictionloopError, match=r'N per g, such as 0\.00980665, or unit = "gf"'):
        found(Recording(path=str(path), column="force"))
    assert found(Recording(path=str(path), column="force", unit="gf")).highest_n == pytest.approx(0.8 * 9.80665e-3)


def test_rows_that_are_missing_or_doubled_are_told_where_a_rate_stands_for_the_times(tmp_path):
    times = [0, 2, 4, 8, 10, 10, 14, 16]
    rows = "".join(f"{t},{t / 10}\n" for t in times)
    path = text(tmp_path, "t [ms],force [N]\n" + rows)
    with pytest.raises(fl.FrictionloopError, match="times: 1 before line 5, 1 before line 8; times no"):
        found(Recording(path=str(path), column="force"))
    said = found(Recording(path=str(path), column="force", rate_hz=500.0)).uneven
    assert "no later than the row before: line 7: t [ms] is '10'; rows are taken 0.002 s apart, at most 0.002 s" in said
    path = text(tmp_path, "t [ms],force [N]\n" + "".join(f"{2 * k},1\n" for k in range(8)))
    assert found(Recording(path=str(path), column="force", rate_hz=500.0)).uneven == ""


def test_a_decimal_comma_below_names_and_units_is_hinted_at(tmp_path):
    path = text(tmp_path, "Zeit;Kraft\nms;gf\n0,0;55,7\n2,0;54,4\n")
    with pytest.raises(
        fl.FrictionloopError, match=r"line 3: '0,0' is no number; a decimal comma\? --disturbance\.decimal ,$"
    ):
        found(Recording(path=str(path), column="Kraft"))
    one = found(Recording(path=str(path), column="Kraft", decimal=","))
    assert (one.unit, one.unit_by, one.samples, one.rate_hz, one.rate_by) == ("gf", "file", 2, 500.0, "'Zeit [ms]'")
