"""Files as strangers write them: each by both ways into the package, with the samples and the rate that are in it."""

from __future__ import annotations

import struct

import h5py
import numpy as np
import pytest
import scipy.io
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import wavfile

import frictionloop as fl
from frictionloop.recordings.file_opening import read_contents
from frictionloop.recordings.force_channel import read_recording, scaled

AT_S = np.arange(600) / 1000
FORCE = np.round(0.5 + 0.1 * np.sin(2 * np.pi * 3 * AT_S), 5)
PAIRS = list(zip(AT_S, FORCE, strict=True))
ROWS = [f"{at:.3f},{force:.5f}" for at, force in PAIRS]
TABLE = "time_s,force_n\n" + "\n".join(ROWS) + "\n"
CODES = ("DATA-GAPS", "LEFT-OUT", "NAMES-FEWER")


def both(path, column="force"):
    """Return samples and rate of a channel as a run and as identification take them, which must be one."""
    taken = scaled(fl.Recording(path=str(path), column=column))
    loaded = fl.identify.load(path, {"f_m": {"column": column}})
    np.testing.assert_array_equal(taken.force, loaded.f_m.values)
    assert 1 / float(loaded.time[1]) == pytest.approx(taken.rate_hz, rel=1e-9)
    return taken.force, taken.rate_hz


# A rate is that of the channel.


def of_hdf5(path):
    with h5py.File(path, "w") as file:
        for name, hertz in (("fast/force_n", 1000.0), ("slow/force_n", 500.0)):
            file[name] = FORCE
            file[name].attrs["fs"] = hertz


def of_groups(path):
    with h5py.File(path, "w") as file:
        for group, hertz in (("fast", 1000.0), ("slow", 500.0)):
            file[f"{group}/force_n"] = FORCE
            file[group].attrs["fs"] = hertz


def of_times(path):
    with h5py.File(path, "w") as file:
        for group, factor in (("fast", 1.0), ("slow", 2.0)):
            file[f"{group}/force_n"], file[f"{group}/time_s"] = FORCE, factor * AT_S


def of_structures(path):
    trial = {"time": AT_S, "signals": {"force_n": FORCE}}  # as Simulink logs
    scipy.io.savemat(path, {"fast": trial, "slow": {"force_n": FORCE, "fs": 500.0}})


def of_tdms(path):
    nptdms = pytest.importorskip("nptdms")
    channels = [
        nptdms.ChannelObject(group, "force_n", FORCE, {"wf_increment": step, "unit_string": "N"})
        for group, step in (("fast", "0,001"), ("slow", 0.002))
    ]
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(channels)


@pytest.mark.parametrize(
    ("name", "write"),
    [("a.h5", of_hdf5), ("b.h5", of_groups), ("c.h5", of_times), ("d.mat", of_structures), ("e.tdms", of_tdms)],
)
def test_a_channel_that_nobody_asked_for_sets_no_rate(tmp_path, name, write):
    write(tmp_path / name)
    fast = "fast/signals/force_n" if name == "d.mat" else "fast/force_n"
    for column, hertz in ((fast, 1000.0), ("slow/force_n", 500.0)):
        force, rate_hz = both(tmp_path / name, column)
        assert rate_hz == hertz
        np.testing.assert_array_equal(force, FORCE)
    seen = fl.identify.channels(tmp_path / name)
    assert seen.rate_hz is None and {each.rate_hz for each in seen.channels} >= {1000.0, 500.0}
    (left,) = (each for each in fl.identify.findings_of(fl.identify.load(tmp_path / name).attrs) if each.code in CODES)
    assert left.code == "LEFT-OUT"


def test_groups_whose_clocks_agree_are_one_recording(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for group in "ab":
            file[f"{group}/force_n"], file[f"{group}/time_s"] = FORCE, AT_S
    assert {*fl.identify.load(tmp_path / "a.h5").data_vars} == {"a/force_n", "b/force_n"}
    assert fl.identify.channels(tmp_path / "a.h5").rate_hz == 1000.0


def test_a_rate_among_settings_counts_where_it_is_the_only_one(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["data/force_n"] = FORCE
        file.create_group("daq").attrs["fs"] = 1000.0
    assert both(tmp_path / "a.h5", "data/force_n")[1] == 1000.0
    with h5py.File(tmp_path / "a.h5", "a") as file:
        file.create_group("other").attrs["fs"] = 500.0
    with pytest.raises(fl.FrictionloopError, match="1000 Hz by 'fs' of 'daq', 500 Hz by 'fs' of 'other'"):
        read_recording(fl.Recording(path=str(tmp_path / "a.h5"), column="data/force_n"), 1000.0)


def test_each_channel_of_an_lvm_has_its_own_step_and_a_stale_one_is_settled(tmp_path):
    pytest.importorskip("lvm_read")
    head = "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\t{}\n***End_of_Header***\t\n\n"
    head += "Channels\t2\nDelta_X\t{}\n***End_of_Header***\t\nX_Value\tforce\tother\tComment\n"
    rows = [f"{force:.5f}\t{force:.5f}" for force in FORCE]
    (tmp_path / "a.lvm").write_text(head.format("No", "0.001\t0.01") + "".join(f"\t{row}\n" for row in rows))
    assert [both(tmp_path / "a.lvm", name)[1] for name in ("force", "other")] == [1000.0, 100.0]
    timed = "".join(f"{at:.3f}\t{row}\n" for at, row in zip(AT_S, rows, strict=True))
    (tmp_path / "b.lvm").write_text(head.format("One", "1.953125E-5\t1.953125E-5") + timed)
    with pytest.raises(fl.FrictionloopError, match=r"1000 Hz by 'time', 51200 Hz by 'Delta_X'.*must be one"):
        scaled(fl.Recording(path=str(tmp_path / "b.lvm"), column="force"))
    assert scaled(fl.Recording(path=str(tmp_path / "b.lvm"), column="force", rate_hz=1000.0)).force.size == 600


def test_columns_of_two_clocks_have_each_their_own(tmp_path):
    rows = "".join(f"{at:.3f},{force:.5f},{2000 * at:.0f},{force:.5f}\n" for at, force in PAIRS)
    (tmp_path / "a.csv").write_text("time_s,force,t_ms,other\n" + rows)
    assert [both(tmp_path / "a.csv", name)[1] for name in ("force", "other")] == [1000.0, 500.0]


# What is no number is a gap where it stands, and nowhere else.


@pytest.mark.parametrize("text", ["--", "N/A", "***", "OVERLOAD", "-", ">1000", "", "#N/A", "nan"])
@pytest.mark.parametrize("count", [1, 10, 150, 250])
def test_text_in_one_column_leaves_the_others_alone(tmp_path, text, count):
    cells = [text if k < count else "21.5" for k in range(600)]
    rows = [f"{row},{cell}\n" for row, cell in zip(ROWS, cells, strict=True)]
    (tmp_path / "a.csv").write_text("time_s,force_n,temp\n" + "".join(rows))
    force, rate_hz = both(tmp_path / "a.csv")
    assert rate_hz == 1000.0 and force.tolist() == FORCE.tolist()
    (tmp_path / "b.csv").write_text("force_n,temp\n" + "".join(row.partition(",")[2] for row in rows))
    bare = scaled(fl.Recording(path=str(tmp_path / "b.csv"), column="force", rate_hz=1000.0))
    assert bare.force.tolist() == FORCE.tolist()
    with pytest.raises(fl.FrictionloopError, match=rf"line 2: temp is .*--disturbance\.start_s {count / 1000:g} "):
        scaled(fl.Recording(path=str(tmp_path / "a.csv"), column="temp"))
    gap = next(each for each in fl.identify.channels(tmp_path / "a.csv").findings if each.code == "DATA-GAPS")
    assert (gap.value, gap.more["row"], gap.where.channel) == (count, 0, "temp")


LINES = {
    "blank": ("\n", 1, "line 302"),
    "double spaced": (None, 599, "lines 3 ..."),
    "marks": (" , \n", 1, "line 302"),
}


@pytest.mark.parametrize("how", LINES)
def test_lines_left_out_are_told_with_their_count_and_the_first(tmp_path, how):
    line, count, where = LINES[how]
    rows = [f"{row}\n" for row in ROWS]
    rows = [each for row in rows for each in (row, "\n")] if line is None else [*rows[:300], line, *rows[300:]]
    (tmp_path / "a.csv").write_text("time_s,force_n\n" + "".join(rows))
    assert both(tmp_path / "a.csv")[0].tolist() == FORCE.tolist()
    (left,) = (each for each in fl.identify.channels(tmp_path / "a.csv").findings if each.code == "LEFT-OUT")
    assert (left.value, left.where.channel) == (count, where)


def test_fewer_names_than_columns_are_told_with_both_counts(tmp_path):
    names, row = ",".join(f"c{k}" for k in range(15)), ",".join(f"{k}.5" for k in range(21))
    (tmp_path / "a.csv").write_text(f"{names}\n" + f"{row}\n" * 9)
    (fewer,) = (each for each in fl.identify.channels(tmp_path / "a.csv").findings if each.code == "NAMES-FEWER")
    assert (fewer.value, fewer.limit) == (15, 21)


HELD = {
    "BOM": "\ufeff" + TABLE,
    "CR only": TABLE.replace("\n", "\r"),
    "CR LF": TABLE.replace("\n", "\r\n"),
    "sep=": "sep=,\n" + TABLE,
    "quoted": "\n".join(",".join(f'"{cell}"' for cell in line.split(",")) for line in TABLE.split("\n")[:-1]),
    "trailing marks": TABLE.replace("\n", ",\n"),
    "an index": "\n".join(f"{k},{line}" for k, line in enumerate(TABLE.split("\n")[:-1])).replace("0,", ",", 1),
    "power lost": TABLE + "\0" * 4096,
    "Arabic digits": TABLE[:15] + TABLE[15:].translate(str.maketrans("0123456789", "٠١٢٣٤٥٦٧٨٩")),
    "Fortran": "time_s,force_n\n" + "".join(f"{at:.3f},{force:.5e}\n".replace("e", "D") for at, force in PAIRS),
    "apostrophes": "time_s,force_n\n" + "".join(f"{at:.3f},'{force:.5f}\n" for at, force in PAIRS),
    "settings": "Subject,7,left\nGain,5\nOperator,me\n\n" + TABLE,
    "percent": "% recorded by me\n% rate 1000 Hz\n" + TABLE,
    "units": "time,force\n[s],[N]\n" + TABLE.partition("\n")[2],
    "padded": "\n".join(f"   {line.replace(',', '    ')}  " for line in TABLE.split("\n")[:-1]),
    "note": "\n".join(f"{line},{'note' if k == 0 else 'ok'}" for k, line in enumerate(TABLE.split("\n")[:-1])),
}


@pytest.mark.parametrize("how", HELD)
def test_texts_of_other_programs(tmp_path, how):
    (tmp_path / "a.csv").write_text(HELD[how], encoding="utf-8", newline="")
    force, rate_hz = both(tmp_path / "a.csv")
    assert rate_hz == 1000.0 and force.tolist() == FORCE.tolist()


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "cp1252"])
def test_encodings_are_found(tmp_path, encoding):
    table = TABLE.replace("force_n", "force_n,21 °C" if encoding == "cp1252" else "force_n")
    (tmp_path / "a.csv").write_bytes(table.encode(encoding))
    assert both(tmp_path / "a.csv")[0].tolist() == FORCE.tolist()


def test_a_header_that_comes_again_is_a_gap_and_a_counter_goes_on(tmp_path):
    (tmp_path / "a.csv").write_text("time_s,force_n\n" + "\n".join([*ROWS[:300], "time_s,force_n", *ROWS[300:]]))
    with pytest.raises(fl.FrictionloopError, match="line 302: time_s is 'time_s'"):
        scaled(fl.Recording(path=str(tmp_path / "a.csv"), column="force"))
    assert fl.identify.channels(tmp_path / "a.csv").channels[1].missing == 1


NUMBERS = st.lists(st.tuples(st.floats(-1e6, 1e6), st.floats(0, 5e3)), min_size=3, max_size=9)


@settings(max_examples=60, deadline=None)
@given(NUMBERS, st.sampled_from(";\t "), st.booleans(), st.sampled_from(",.'\u202f"), st.integers(0, 4))
def test_decimals_and_thousands_are_those_of_the_number_or_refused(tmp_path_factory, pairs, mark, point, group, digits):
    """Python's own formatting and NumPy's rounding are the other reader."""
    decimal = "." if point else ","
    if group in (decimal, "\u202f" if mark == " " else ""):
        group = {".": ",", ",": "."}[decimal]
    path = tmp_path_factory.mktemp("t") / "a.csv"

    def cell(value):
        return f"{value:,.{digits}f}".replace(",", "_").replace(".", decimal).replace("_", group)

    path.write_text("\n".join([mark.join("ab"), *(mark.join(map(cell, pair)) for pair in pairs)]), encoding="utf-8")
    written = [[float(f"{value:.{digits}f}") for value in pair] for pair in pairs]
    try:
        # 1.234 in every cell is taken for a decimal point.
        read = read_contents(path, decimal if group == "." and not digits else None).channels
    except fl.FrictionloopError as refused:
        assert "must be told by decimal" in str(refused)
        read = read_contents(path, decimal).channels
    np.testing.assert_array_equal(np.transpose([each.samples for each in read]), written)


TITLES = st.lists(st.sampled_from(["Rig 5", "Operator,me", "Date,2024-03-05", "", "# a note", "Rate,1000", "x,y,z,w"]))


@settings(max_examples=60, deadline=None)
@given(TITLES, st.booleans(), st.integers(0, 30), st.sampled_from(["--", "N/A", "n.a.", "***", ">9999", "OL"]))
def test_whatever_stands_above_no_row_is_lost(tmp_path_factory, above, units, late, text):
    path = tmp_path_factory.mktemp("t") / "a.csv"
    rows = [f"{row},{text if k < late else 21.5}" for k, row in enumerate(ROWS[:60])]
    names = ["time,force,temp", "[s],[mN],[degC]"] if units else ["time_s,force_mN,temp"]
    path.write_text("\n".join([*above, *names, *rows]))
    time, force, temp = read_contents(path).channels
    assert (time.name, force.name, force.unit, temp.name) == ("time", "force", "mN", "temp")
    assert force.samples.tolist() == FORCE[:60].tolist() and np.isnan(temp.samples).sum() == late


def test_a_mark_that_is_given_is_that_of_every_way_in(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("t_ms;force_n\n" + "".join(f"{k};{990 + k:,d}\n" for k in range(20)))
    for decimal, force in ((".", 1009.0), (",", 1.009)):
        loaded = fl.identify.load(path, {"f_m": "force"}, decimal=decimal)
        assert scaled(fl.Recording(path=str(path), column="force", decimal=decimal)).force[-1] == force
        assert loaded.f_m.values[-1] == force
        assert fl.identify.channels(path, decimal=decimal).channels[1].most == (1009.0 if decimal == "." else 999.0)


# Binary files are what they are.


def test_netcdf_of_both_kinds_and_times_in_ns(tmp_path):
    stamps = np.datetime64("2024-03-05T10:00", "ns") + (1e9 * AT_S).round().astype("timedelta64[ns]")
    data = xr.Dataset({"force": ("time", FORCE, {"units": "N"})}, {"time": stamps})
    data.to_netcdf(tmp_path / "four.nc", engine="h5netcdf")
    data.assign_coords(time=("time", AT_S, {"units": "s"})).to_netcdf(tmp_path / "three.nc", engine="scipy")
    for name in ("four.nc", "three.nc"):
        force, rate_hz = both(tmp_path / name)
        assert rate_hz == pytest.approx(1000.0) and force.tolist() == FORCE.tolist()


def test_structured_arrays_are_their_fields(tmp_path):
    table = np.array(PAIRS, dtype=[("time_s", "f8"), ("force_n", "f8")])
    np.save(tmp_path / "a.npy", table)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["rec"], file["deep"] = table, FORCE[None, :, None]
    for name, column in (("a.npy", "array/force_n"), ("a.h5", "rec/force_n")):
        force, rate_hz = both(tmp_path / name, column)
        assert rate_hz == 1000.0 and force.tolist() == FORCE.tolist()
    assert next(each for each in read_contents(tmp_path / "a.h5").channels if each.name == "deep").samples.size == 600
    trials = np.zeros(2, dtype=[("t", object), ("force_n", object)])
    trials[0], trials[1] = (AT_S, FORCE), (AT_S, 2 * FORCE)
    scipy.io.savemat(tmp_path / "a.mat", {"trial": trials})
    np.testing.assert_array_equal(both(tmp_path / "a.mat", "trial(2)/force_n")[0], 2 * FORCE)


def test_what_is_no_file_of_signals_says_the_way_in(tmp_path):
    (tmp_path / "a.xlsx").write_bytes(b"PK\3\4")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["force"] = np.array([b"0.5", b"0.6"])
    for name, said in (("a.xlsx", "a workbook: save its sheet as .csv"), ("a.h5", "force left out: text")):
        with pytest.raises(fl.FrictionloopError, match=said):
            read_contents(tmp_path / name)


def riff(samples, kind=1, bits=16, rate_hz=1000, before=b"", sizes=None):
    body = struct.pack("<HHIIHH", kind, 1, rate_hz, rate_hz * bits // 8, bits // 8, bits)
    size = len(samples) if sizes is None else sizes
    body = b"WAVEfmt " + struct.pack("<I", 16) + body + before + b"data" + struct.pack("<I", size) + samples
    return b"RIFF" + struct.pack("<I", len(body) if sizes is None else sizes) + body


WORDS = np.arange(-300, 300, dtype="<i2")
SOUNDS = {
    "sizes of 0": (riff(WORDS.tobytes(), sizes=0), "TAKEN-FOR"),
    "sizes not known": (riff(WORDS.tobytes(), sizes=0xFFFFFFFF), "TAKEN-FOR"),
    "killed": (riff(WORDS.tobytes() + b"\0", sizes=2000), "DATA-GAPS"),
    "an odd chunk": (riff(WORDS.tobytes(), before=b"LIST\5\0\0\0INFOx"), None),
    "an odd chunk that is padded": (riff(WORDS.tobytes(), before=b"LIST\5\0\0\0INFOx\0"), None),
    "no rate": (riff(WORDS.tobytes(), rate_hz=0), "RATE-UNKNOWN"),
}


@pytest.mark.parametrize("how", SOUNDS)
def test_a_wav_whose_recorder_came_to_no_end_is_read(tmp_path, how):
    content, code = SOUNDS[how]
    (tmp_path / "a.wav").write_bytes(content)
    taken = scaled(fl.Recording(path=str(tmp_path / "a.wav"), rate_hz=1000.0))
    assert taken.force.tolist() == (WORDS / 2**15).tolist()
    assert [each.code for each in fl.identify.channels(tmp_path / "a.wav").findings] == [code] * (code is not None)


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(["u1", "i2", "i4", "f4", "f8"]), st.integers(1, 3), st.integers(2, 50), st.integers(1, 10**6))
def test_a_wav_is_what_scipy_reads_of_it(tmp_path_factory, kind, width, rows, rate_hz):
    path = tmp_path_factory.mktemp("t") / "a.wav"
    raw = np.random.default_rng(rows).integers(0, 256, (rows, width * np.dtype(kind).itemsize), dtype=np.uint8)
    samples = np.linspace(-2, 2, rows * width).reshape(rows, width).astype(kind) if kind[0] == "f" else raw.view(kind)
    wavfile.write(path, rate_hz, samples)
    found = read_contents(path).channels
    _, other = wavfile.read(path)
    other = other.reshape(rows, width)
    full = {"u": 128.0, "i": 2.0 ** (8 * other.itemsize - 1), "f": 1.0}[kind[0]]
    np.testing.assert_array_equal(
        np.transpose([each.samples for each in found]), (other - (128.0 if kind == "u1" else 0.0)) / full
    )
    assert all([*each.rates_hz.values()] == [rate_hz] for each in found)
