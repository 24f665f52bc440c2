"""Recordings: every format gives back what was written, resampling keeps the signal, bad files get one line."""

from __future__ import annotations

import re
import tempfile
import wave
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.io import savemat, wavfile

from frictionloop.parameters import Recording, Samples, paper
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.force_channel import read_recording
from frictionloop.recordings.force_channel import scaled as found

TABLE = np.array([[0.1, -1.5, 2e-7], [0.2, 3.25, 1e9], [0.3, -0.125, -4.0], [0.4, 2.5, 7.0]])

TIMES = "column = '0' (the default of --disturbance.column and --setpoint.column) holds times"


def read(path, column="0", rate_hz=100.0, at_hz=100.0, **more):
    return read_recording(Recording(path=str(path), column=column, rate_hz=rate_hz, **more), at_hz)


def refusal(path, *arguments, **more):
    with pytest.raises(FrictionloopError) as caught:
        read(path, *arguments, **more)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    return message.removeprefix(f"{path}: ")


def text(folder, content, name="force.csv"):
    path = folder / name
    path.write_text(content, encoding="utf-8", newline="")
    return path


def write(path, samples):
    """Write a table of samples in the format of the path's name, return what a column k of it is called."""
    if path.suffix in (".csv", ".tsv", ".txt"):
        mark = {".csv": ",", ".tsv": "\t", ".txt": " "}[path.suffix]
        np.savetxt(path, samples, fmt="%.17g", delimiter=mark, header=mark.join("abc"), comments="")
        return "{k}"
    if path.suffix == ".wav":
        wavfile.write(path, 100, samples)
        return "{k}"
    if path.name == "v7.mat":
        with h5py.File(path, "w", userblock_size=512) as file:
            file["dataQ"] = samples.T
        path.write_bytes(b"MATLAB 7.3 MAT-file".ljust(512) + path.read_bytes()[512:])
    elif path.suffix == ".mat":
        savemat(path, {"other": np.arange(3.0), "dataQ": samples})
    else:
        with h5py.File(path, "w") as file:
            file["group/rows"], file["dataQ"] = samples.T, samples
    return "dataQ[:, {k}]"


@settings(deadline=None)
@given(
    data=st.data(),
    samples=arrays(np.float64, 20, elements=st.floats(-1e3, 1e3)),
    scale=st.floats(-10, 10),
    offset_n=st.floats(-10, 10),
    remove_mean=st.booleans(),
)
def test_the_window_scale_and_mean(data, samples, scale, offset_n, remove_mean):
    start = data.draw(st.integers(0, 18))
    stop = data.draw(st.integers(start + 1, 20))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "a.mat")
        write(path, samples[:, None])
        window = {"start_s": start / 100, "stop_s": stop / 100, "scale": scale, "offset_n": offset_n}
        force = read(path, "dataQ", remove_mean=remove_mean, **window)
    used = samples[start : stop + 1]
    mean = used.mean() if remove_mean else 0.0
    assert np.array_equal(force, offset_n + scale * (used - mean))
    assert force.dtype == np.float64
    if remove_mean:
        assert force.mean() == pytest.approx(offset_n, abs=1e-10)


# Text


@pytest.mark.parametrize(
    "content",
    [
        "force,x\n1.5,0\n-2,0\n",
        "# made by hand, today's\n\nforce\tx\n\n1.5\t0\n# a note; \"here\n-2\t0\n\n\n",
        "force\n1.5\n-2",
        "x, force\n0, 1.5\n0, -2\n",
    ],
)
def test_text_dialects(tmp_path, content):
    assert read(text(tmp_path, content), "force").tolist() == [1.5, -2.0]


def test_a_single_column_name_may_hold_spaces(tmp_path):
    assert read(text(tmp_path, "lateral force\n1\n2\n"), "lateral force").tolist() == [1.0, 2.0]


def test_a_path_object_names_a_file(tmp_path):
    path = text(tmp_path, "1\n2\n")
    assert Recording(path=path) == Recording(path=str(path))


def test_without_a_header_the_first_row_is_data(tmp_path):
    assert read(text(tmp_path, "12:00:01.00,1\n12:00:01.01,2\n"), "1").tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("cell", "said"),
    [("nan", "'nan'"), ("-inf", "'-inf'"), ("", "blank"), ("n/a", "'n/a'"), ("1.5.2", "'1.5.2'"), ("x" * 99, "'xxx")],
)
@pytest.mark.parametrize("header", ["", "x,force\n"])
def test_a_bad_cell_is_refused_with_its_line(tmp_path, cell, said, header):
    path = text(tmp_path, f"# note\n{header}0,1\n\n0,{cell}\n0,2\n".replace("\n\n", "\n# more\n"))
    message = refusal(path, "1")
    name = "force" if header else "column 1"
    assert message.startswith(f"line {5 if header else 4}: {name} is {said}")
    assert message.endswith("; accepted: a finite number")
    assert len(message) < 110


@pytest.mark.parametrize(
    ("content", "column", "said"),
    [
        ("force\n1\n2,7\n", "force", "line 3: force is in a row of 2 cells, of 1 columns; accepted: a finite number"),
        (
            "t,force\n0,5,1,25\n1,0,1,5\n",
            "force",
            "line 2 = '0,5,1,25': must be 2 cells; decimal commas? part columns ",
        ),
        (
            "t;force\n0.01;1.25\n0.02;1,5\n",
            "force",
            "line 3: force is '1,5'; decimal = ','?; accepted: a finite number",
        ),
        ("1,2\n3,4,5\n", "0", "line 2: column 0 is in a row of 3 cells, of 2 columns; accepted: a finite number"),
    ],
)
def test_a_decimal_comma_is_never_read_as_another_number(tmp_path, content, column, said):
    assert refusal(text(tmp_path, content), column).startswith(said)


@pytest.mark.parametrize("mark", [";", "\t", " "])
def test_decimal_commas_are_read_told_or_not(tmp_path, mark):
    path = text(tmp_path, "t;force\n0,0;1,25\n0,01;-1,5e-3\n".replace(";", mark))
    for decimal in (",", None):
        assert read(path, "force", rate_hz=None, decimal=decimal).tolist() == [1.25, -1.5e-3]


def test_a_bad_cell_outside_the_window_does_no_harm(tmp_path):
    path = text(tmp_path, "nan\n1\n2\nlost\n")
    assert read(path, start_s=0.01, stop_s=0.02).tolist() == [1.0, 2.0]


# The rate


@pytest.mark.parametrize(
    ("name", "per_s"),
    [
        ("time", 1),
        ("time_s", 1),
        ("t", 1),
        ("Time (s)", 1),
        ("Time [ms]", 1e3),
        ("t_us", 1e6),
        ("TIME", 1),
        ("timestamp [sec]", 1),
    ],
)
def test_a_column_of_times_gives_the_rate(tmp_path, name, per_s):
    rows = "".join(f"{(5 + k * 1e-4) * per_s:.7f},{k % 7}\n" for k in range(50))
    path = text(tmp_path, f"{name},force\n{rows}")
    assert read(path, "force", rate_hz=None, at_hz=10_000.0).tolist() == [k % 7 for k in range(50)]
    assert refusal(path, "force", rate_hz=100.0).startswith("rate_hz = 100 Hz: must be 10000, as in the file")
    assert refusal(path, "0", rate_hz=None) == f"{TIMES}; accepted: 'force'"


# Units


@pytest.mark.parametrize("header", ["Ft [mN]", "Ft (mN)", "ft_mn", "Ft [millinewton]"])
@pytest.mark.parametrize("unit", [None, "mN"])
def test_a_column_in_millinewtons_is_scaled(tmp_path, header, unit):
    path = text(tmp_path, f"Time (s),{header}\n0,250\n0.01,-500\n")
    assert read(path, header, rate_hz=None, unit=unit).tolist() == [0.25, -0.5]
    assert read(path, header.split()[0].split("_")[0], rate_hz=None, unit=unit).tolist() == [0.25, -0.5]


def test_a_unit_beside_the_column_scales_it(tmp_path):
    path = text(tmp_path, "250\n-500\n")
    assert read(path, unit="mN").tolist() == [0.25, -0.5]
    assert read(path).tolist() == [250.0, -500.0]
    assert read(path, unit="V", scale=2.0).tolist() == [500.0, -1000.0]


def test_a_scale_that_contradicts_its_unit_is_refused():
    with pytest.raises(ValueError, match='scale = 2 contradicts unit = "mN"'):
        Recording(path="a.csv", unit="mN", scale=2.0)


@pytest.mark.parametrize(
    ("times", "said"),
    [
        ([0, 1, 2, 4, 5], "rows missing in the times: 1, first before line 5; accepted: steps of 1 s if 't' is in s,"),
        ([0, 1, 2, 3.002, 4.002], "steps up to 0.2 % off, most before line 5; accepted"),
        ([0, 1, 1, 2, 3], "times no later than the row before: 1, first line 4: t is '1'; accepted"),
        ([3, 2, 1], "times no later than the row before: 2, first line 3: t is '2'; accepted"),
        ([0, 1, "", 3], "line 4: t is blank;"),
    ],
)
def test_uneven_times_are_refused_with_the_line_of_the_gap(tmp_path, times, said):
    path = text(tmp_path, "t,force\n" + "".join(f"{t},1\n" for t in times))
    assert refusal(path, "force", rate_hz=None).startswith(said)
    assert read(path, "force").size == len(times)


def test_a_window_past_the_end(tmp_path):
    path = text(tmp_path, "1\n2\n3\n4\n")
    lasts = "from 0 to 0.03"
    assert refusal(path, start_s=0.04) == f"start_s = 0.04 s: must be {lasts}"
    assert refusal(path, start_s=1e308).startswith("start_s = 1e+308 s: must be")
    assert refusal(path, stop_s=0.05) == f"stop_s = 0.05 s: must be {lasts}"
    assert read(path, start_s=0.03).tolist() == [4.0]
    assert read(path, stop_s=0.04).tolist() == [1.0, 2.0, 3.0, 4.0]


# WAV, HDF5, NetCDF, MAT


def test_wav_of_24_bits(tmp_path):
    with wave.open(str(tmp_path / "a.wav"), "wb") as file:
        file.setparams((1, 3, 100, 0, "NONE", ""))
        file.writeframes(b"".join(n.to_bytes(3, "little", signed=True) for n in (-(2**23), 0, 2**22)))
    assert read(tmp_path / "a.wav").tolist() == [-1.0, 0.0, 0.5]


@pytest.mark.parametrize("name", ["a.h5", "a.mat", "v7.mat"])
def test_rows_columns_and_what_is_there(tmp_path, name):
    path = tmp_path / name
    write(path, TABLE)
    assert read(path, "dataQ[2, :]").tolist() == TABLE[2].tolist()
    assert read(path, " /dataQ [ : ,1] ").tolist() == TABLE[:, 1].tolist()
    for column in ("dataQ", "dataQ[:, 3]", "dataQ[4, :]"):
        assert refusal(path, column).startswith(f"column = {column!r}: must be 'dataQ[:, 0]' to 'dataQ[:, 2]'")
    assert "'dataQ[:, 0]'" in refusal(path, "dataq[:, 0]")
    assert "dataQ[:, 0]" in refusal(path, "dataQ[0]")


def test_a_dataset_by_number_or_in_a_group(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["trial/force"], file["text"], file["one"] = [1, 2], "a word", 3.0
    assert read(tmp_path / "a.h5").tolist() == [1.0, 2.0]
    assert read(tmp_path / "a.h5", "trial/force").tolist() == [1.0, 2.0]
    assert refusal(tmp_path / "a.h5", "trial/force[:, 0]").endswith("must be 'trial/force'")
    assert refusal(tmp_path / "a.h5", "text").endswith("accepted: trial/force")
    savemat(tmp_path / "a.mat", {"trial": {"force": [1, 2], "name": "x"}, "word": "abc"})
    assert read(tmp_path / "a.mat", "trial/force").tolist() == read(tmp_path / "a.mat").tolist() == [1.0, 2.0]
    savemat(tmp_path / "b.mat", {"word": "abc"})
    assert refusal(tmp_path / "b.mat").startswith("holds no numbers")


def test_netcdf_packing_is_undone_and_missing_values_refused(tmp_path):
    path = tmp_path / "a.nc"
    packing = {"dtype": "int16", "scale_factor": 0.5, "add_offset": 10.0, "_FillValue": -1}
    data = xr.Dataset({"force": ("time", [10.5, 12.0, np.nan])})
    data.to_netcdf(path, engine="h5netcdf", encoding={"force": packing})
    assert read(path, "force", stop_s=0.01).tolist() == [10.5, 12.0]
    assert refusal(path, "force") == "column 'force' at index 2 is nan; accepted: a finite number"


@pytest.mark.parametrize("name", ["a.h5", "a.mat", "v7.mat", "a.wav"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_bad_sample_is_refused_with_its_index(tmp_path, name, bad):
    samples = TABLE.copy()
    samples[2, 1] = bad
    column = write(tmp_path / name, samples).format(k=1)
    assert refusal(tmp_path / name, column, start_s=0.01) == (
        f"column {column!r} at index 2 is {bad}; accepted: a finite number"
    )


# Files that are no recordings


def test_a_file_without_samples(tmp_path):
    assert refusal(text(tmp_path, "# only a note\n\n")) == "rows of numbers = 0: must be 1 or more"
    assert refusal(text(tmp_path, "force\n"), "force").startswith("rows of numbers = 0")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["force"] = np.empty(0)
    assert refusal(tmp_path / "a.h5", "force").startswith("holds no numbers")


@pytest.mark.parametrize("name", ["a.h5", "a.nc", "a.mat", "v7.mat"])
@pytest.mark.parametrize("kept", [0.02, 0.5, 0.99])
def test_a_truncated_file(tmp_path, name, kept):
    path = tmp_path / name
    column = write(path, np.random.default_rng(0).standard_normal((500, 3))).format(k=0)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(kept * len(whole))])
    assert refusal(path, column).startswith(("cannot be read, empty or damaged (", "damaged or encrypted ("))


@pytest.mark.slow
@settings(deadline=None)
@given(name=st.sampled_from(["a.csv", "a.h5", "a.mat", "a.wav"]), content=st.binary(max_size=200))
def test_any_bytes_are_read_or_refused_in_one_line(name, content):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, name)
        path.write_bytes(content)
        try:
            force = read(path)
        except FrictionloopError as error:
            assert re.fullmatch(rf"{re.escape(str(path))}: [^\n]+", str(error))
        else:
            assert np.isfinite(force).all()


# What other programs write: read rightly, or refused


@pytest.mark.parametrize(
    "header", ["Ft/mN", "Ft in mN", "Ft mN", '"Ft, mN"', "Ft [mN]\n", "Ft\nmN", "Ft\n(mN)", "Ft\n\u00b5N"]
)
def test_a_unit_is_found_wherever_the_header_has_it(tmp_path, header):
    name, _, unit = header.partition("\n")
    lines = [f"t;{name}", f"s;{unit}"] if unit else [f"t/s;{name}"]
    path = text(tmp_path, "\n".join([*lines, "0;250", "0.01;-500"]) + "\n")
    expected = np.array([0.25, -0.5]) * (1e-3 if "\u00b5" in header else 1.0)
    assert read(path, "Ft", rate_hz=None) == pytest.approx(expected)


def test_a_unit_that_is_not_known_is_refused(tmp_path):
    path = text(tmp_path, "t,Ft [dyn],Ft (left)\n0,1,2\n0.01,3,4\n")
    told = refusal(path, "Ft [dyn]")
    assert told == "column 'Ft' in dyn: scale is missing: N per dyn, or unit = \"N\""
    assert read(path, "Ft (left)", unit="N").tolist() == [2.0, 4.0]
    assert read(path, "Ft [dyn]", scale=2.0).tolist() == [2.0, 6.0]


def test_numbers_over_numbers_are_names_where_text_stands_beside_them(tmp_path):
    assert read(text(tmp_path, "t,1,2\n0,5,6\n0.01,7,8\n"), "2", rate_hz=None).tolist() == [6.0, 8.0]
    assert read(text(tmp_path, "load,1000\n0.1,0.2\n0.3,0.4\n"), "1").tolist() == [0.2, 0.4]
    told = refusal(text(tmp_path, "0,1\n0.0,0.3\n0.01,0.4\n"), "1")
    assert told.startswith("line 1 = '0, 1': must be names")


def test_a_comment_right_above_the_numbers_is_a_line_of_names(tmp_path):
    path = text(tmp_path, "# ATI Nano17\n# t (s),F [mN]\n0,1\n0.01,2\n")
    assert read(path, "F", rate_hz=None).tolist() == [1e-3, 2e-3]
    assert read(text(tmp_path, "# one, two words\n0.1\n0.2\n"), "0").tolist() == [0.1, 0.2]


@pytest.mark.parametrize("units", ["s,mN,dB", "[s],[mN],[-]", "s,mN,Hz", "s,mN,-"])
def test_a_line_of_units_stays_out_of_the_names_and_is_told(tmp_path, units):
    path = text(tmp_path, f"Rig 2\nt,Ft,level\n{units}\n0,1000,3\n0.01,2000,4\n")
    assert read(path, "Ft", rate_hz=None).tolist() == [1.0, 2.0]
    one = found(Recording(path=str(path), column="Ft"))
    assert (one.channel.name, one.unit, one.part.by) == ("Ft", "mN", "'t'")


def test_two_columns_of_one_name_are_told_apart_by_number(tmp_path):
    path = text(tmp_path, "t,F,F\n0,1,2\n0.01,3,4\n")
    assert refusal(path, "F") == "column 'F' = '2 times there': must be 'F 1', 'F 2'"
    assert read(path, "2").tolist() == [2.0, 4.0]


@pytest.mark.parametrize(
    ("content", "decimal", "said"),
    [
        ("0,5\n0,6\n0,7\n", None, "line 1 = '0,5': must be one number, by decimal = ',', or two below names"),
        ("0,05\n1,60\n", None, "line 1 = '0,05': must be one number, by decimal = ',', or two below names"),
        ("F\n1_000\n2\n", ".", "line 2: F is '1_000'"),
        ("F;G\n1,040;1\n999;2\n", None, "'1,040' = '1.04 or 1040': must be told by decimal = ',' or '.'"),
        ("F\n1.040\n999\n", None, "'1.040' = '1040 or 1.04': must be told by decimal = ',' or '.'"),
    ],
)
def test_a_mark_within_a_number_is_asked_about(tmp_path, content, decimal, said):
    assert refusal(text(tmp_path, content), decimal=decimal).startswith(said)


@pytest.mark.parametrize(
    ("cells", "decimal", "numbers"),
    [
        ("0,5;1.040,25", None, [0.5, 1040.25]),
        ("0.5;1,040.25", None, [0.5, 1040.25]),
        ("1'000;1\u202f000,5", None, [1000.0, 1000.5]),
        ("1,040;999", ".", [1040.0, 999.0]),
        ("1,040;999", ",", [1.04, 999.0]),
        ("1,234,567;1,000", None, [1234567.0, 1000.0]),
        ("1.234;1.235", None, [1.234, 1.235]),
        ("\u22121.5;1.5D2", None, [-1.5, 150.0]),
        ("\u0661.\u0665;2", None, [1.5, 2.0]),
    ],
)
def test_a_number_that_can_be_read_in_one_way_is(tmp_path, cells, decimal, numbers):
    path = text(tmp_path, "F;G\n" + 3 * f"{cells}\n")
    assert [read(path, name, decimal=decimal)[0] for name in "FG"] == numbers


def test_times_without_a_unit_may_be_counts(tmp_path):
    path = text(tmp_path, "time,F\n0,1\n1,2\n2,4\n")
    assert "'time' without a unit: in s 1 Hz, in ms 1000 Hz;" in refusal(path, "F", rate_hz=None)
    assert read(path, "F").tolist() == [1.0, 2.0, 4.0]
    assert read(text(tmp_path, "time_s,F\n0,1\n1,2\n2,4\n"), "F", rate_hz=None, at_hz=1.0).tolist() == [1, 2, 4]


@pytest.mark.parametrize("jitter", [0, 0.02, np.nan])
def test_a_rate_may_differ_little_from_uneven_times(tmp_path, jitter):
    path = text(tmp_path, "t,F\n" + "".join(f"{0.01 * (k + jitter if k == 3 else k):g},{k % 2}\n" for k in range(9)))
    assert read(path, "F").size == 9
    assert "rate_hz = 10 Hz: must be" in refusal(path, "F", rate_hz=10.0)


def test_a_force_that_rises_evenly_beside_times_is_one(tmp_path):
    path = text(tmp_path, "t,F\n0,0.1\n0.01,0.2\n0.02,0.3\n")
    assert read(path, "1", rate_hz=None).tolist() == [0.1, 0.2, 0.3]
    bare = text(tmp_path, "0.1,1\n0.2,5\n0.3,2\n", "bare.csv")
    assert refusal(bare, "0").startswith(TIMES)
    assert read(bare, "0", unit="N").tolist() == [0.1, 0.2, 0.3]


def test_a_saved_run_is_a_recording(tmp_path):
    run = xr.Dataset(
        {"f_m": ("time", [1.0, 2.0, 3.0], {"units": "mN"})}, {"time": ("time", [0.0, 0.5, 1.0], {"units": "s"})}
    )
    run.to_netcdf(tmp_path / "run.h5", engine="h5netcdf")
    assert read(tmp_path / "run.h5", "f_m", rate_hz=None, at_hz=2.0) == pytest.approx([1e-3, 2e-3, 3e-3])


@pytest.mark.parametrize("units", [np.bytes_("mN"), "mN", np.array(["mN"], dtype=h5py.string_dtype())])
def test_an_attribute_is_read_however_it_is_written(tmp_path, units):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["f"] = np.array([100.0, 200.0])
        file["f"].attrs["units"] = units
    assert read(tmp_path / "a.h5", "f") == pytest.approx([0.1, 0.2])


def test_an_attribute_that_is_no_known_unit_is_refused(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["f"] = np.array([100.0, 200.0])
        file["f"].attrs["units"] = "dyn"
    assert refusal(tmp_path / "a.h5", "f").startswith("column 'f' in dyn: scale is missing")


def test_what_was_found_has_the_unit_and_what_tells_it(tmp_path):
    path = text(tmp_path, "t,Ft [mN]\n0,250\n0.01,-500\n")
    one = found(Recording(path=str(path), column="Ft"))
    assert (one.unit, one.unit_by, one.force.min()) == ("mN", "file", -0.5)
    wavfile.write(tmp_path / "a.wav", 100, np.zeros(8, np.int16))
    (tmp_path / "bare.csv").write_text("t,F\n0,0.1\n0.01,0.3\n0.02,0.2\n")
    bare = Recording(path=str(tmp_path / "bare.csv"), column="F")
    given = [bare, *(bare.model_copy(update=each) for each in ({"unit": "N"}, {"scale": 1.0}))]
    given.append(Recording(path=str(tmp_path / "a.wav")))
    assert [found(each).unit_by for each in given] == ["taken for N", "given", "scale", "full scale"]


# Arrays


def over(time, units="s", force_units="N", values=(0.3, 0.5, 0.4)):
    time = xr.Variable("time", time, {"units": units} if units else {})
    return xr.DataArray(np.array(values), {"time": time}, ["time"], attrs={"units": force_units})


@pytest.mark.parametrize(
    "array",
    [
        over([0.0, 0.01, 0.02]),
        over([0, 10, 20], "ms"),
        over(np.array([0, 10, 20], "timedelta64[ms]"), None),
        over(np.array(["2024-01-01T00:00:00.00", "2024-01-01T00:00:00.01", "2024-01-01T00:00:00.02"], "M8[ns]"), None),
        over([0.0, 0.01, 0.02], None, "mN", (300, 500, 400)),
    ],
)
def test_a_variable_of_xarray_is_a_signal(array):
    signal = paper().evolve({"disturbance": array}).disturbance
    assert signal.rate_hz == 100.0
    assert signal.values_n == pytest.approx((0.3, 0.5, 0.4))


WRONG = {
    "no unit": (over([0, 1, 2], None), r'rise by 1 .*attrs\["units"\]'),
    "a gap": (over([0.0, 0.01, 0.02, 0.05], values=(0.3,) * 4), "2, first before index 3;"),
    "jitter": (over([0.0, 0.01, 0.021]), "4.8 % off, .*before index 1"),
    "falling": (over([0.02, 0.01, 0.0]), r"2, first index 1: 0.01 s"),
    "hours": (over([0, 1, 2], "h"), "times: units = 'h': must be s, ms, us, ns or min"),
    "text": (over(["a", "b", "c"], None), "times: dtype = '<U1': must be numbers"),
    "no times": (xr.DataArray([0.3, 0.5], dims="time"), "array.assign_coords"),
    "dimension": (over([0.0, 0.01, 0.02]).rename(time="t"), "'t': .*'time'"),
    "one sample": (over([0.0], values=(0.3,)), "array = 1 samples: must be at least 2"),
    "two dimensions": (over([0.0, 0.01, 0.02]).expand_dims("trial"), r"\(1, 3\) over 'trial', 'time'"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_a_variable_with_wrong_times_says_what_is_wrong(name):
    array, said = WRONG[name]
    for signal_of in (lambda: paper().evolve({"disturbance": array}), lambda: Samples(values_n=array)):
        with pytest.raises(FrictionloopError, match=said) as caught:
            signal_of()
        assert len(str(caught.value)) < 250


def test_samples_of_a_variable_take_its_rate_and_refuse_another():
    array = over([0.0, 0.01, 0.02], None, "mN", (300, 500, 400))
    assert (
        Samples(values_n=array)
        == Samples(values_n=array, rate_hz=100)
        == Samples(values_n=(0.3, 0.5, 0.4), rate_hz=100)
    )
    with pytest.raises(FrictionloopError, match=r"rate_hz = 50: .*100"):
        Samples(values_n=array, rate_hz=50)
    counted = over([0, 1, 2], None)  # no unit: the rate settles it
    assert Samples(values_n=counted, rate_hz=50).rate_hz == 50
    assert Samples(values_n=xr.DataArray([0.3, 0.5], dims="k"), rate_hz=np.int64(50)).rate_hz == 50
    with pytest.raises(FrictionloopError, match="rate_hz = -1"):
        Samples(values_n=array, rate_hz=-1)


# Resampling


def signal(time_s):
    return 3 + 0.5 * time_s + np.sin(2 * np.pi * 7.3 * time_s + 0.4)


@pytest.mark.parametrize("at_hz", [500.0, 882.0, 997.0, 333.3, 5000.0, 44100.0])
def test_a_tone_keeps_its_place_at_another_rate(tmp_path, at_hz):
    path = tmp_path / "a.h5"
    write(path, signal(np.arange(2000) / 1000)[:, None])
    force = read(path, "dataQ", rate_hz=1000.0, at_hz=at_hz)
    time_s = np.arange(force.size) / at_hz
    assert time_s[-1] <= 1.999 < time_s[-1] + 1.001 / at_hz
    inner = (time_s > 0.15) & (time_s < 1.85)
    assert np.max(np.abs(force - signal(time_s))[inner]) < 2e-5
    assert np.max(np.abs(force - signal(time_s))) < 1e-3
    assert force[0] == pytest.approx(signal(0.0), abs=1e-9)


@settings(deadline=None)
@given(at_hz=st.integers(10, 2000).map(float), level=st.floats(-5, 5), slope=st.floats(-5, 5))
def test_a_straight_line_stays_one_to_its_ends(at_hz, level, slope):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "a.mat")
        write(path, (level + slope * np.arange(101) / 100)[:, None])
        force = read(path, "dataQ", at_hz=at_hz)
    assert force == pytest.approx(level + slope * np.arange(force.size) / at_hz, abs=1e-9)


def test_what_the_lower_rate_cannot_hold_is_taken_out(tmp_path):
    path, time_s = tmp_path / "a.h5", np.arange(4000) / 1000
    write(path, np.sin(2 * np.pi * 130 * time_s)[:, None])
    inner = read(path, "dataQ", rate_hz=1000.0, at_hz=250.0)[100:-100]
    assert np.max(np.abs(inner)) < 2e-5
