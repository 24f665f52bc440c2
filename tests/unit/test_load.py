"""Files of every format as recordings: the same samples, the rate, the map, and what is refused in one line."""

from __future__ import annotations

import numpy as np
import pytest
import recorded_files as files
import scipy.io

import frictionloop as fl
from frictionloop.recordings.text_tables import read_table

RATE = 8000.0


def columns(samples=2000):
    draw = np.random.default_rng(3)
    return {"hammer": draw.normal(size=samples), "force": 0.1 * draw.normal(size=samples)}


def left_out(path):
    found = fl.identify.channels(path).findings
    return {each.where.channel: each.more["reason"] for each in found if each.code == "LEFT-OUT"}


def complaint(*arguments, **named):
    with pytest.raises(fl.FrictionloopError) as failure:
        fl.identify.load(*arguments, **named)
    assert "\n" not in str(failure.value)
    return str(failure.value)


@pytest.mark.parametrize("name", files.FORMATS)
def test_every_format_gives_the_samples_and_the_rate_that_were_written(tmp_path, name):
    path, written = tmp_path / name, columns()
    files.FORMATS[name](path, written, RATE)
    map_ = {"hammer": 0, "f_m": 1} if name.endswith(".wav") else {"hammer": "hammer", "f_m": "force"}
    told = {each: {"column": column, "unit": "V", "scale": 0.5} for each, column in map_.items()}
    run = fl.identify.load(path, told)
    assert 1 / float(run.time[1] - run.time[0]) == pytest.approx(RATE, rel=1e-6)
    digits = 1e-6 if name.endswith((".wav", ".uff")) else 1e-9
    np.testing.assert_allclose(run.hammer, 0.5 * written["hammer"], atol=digits)
    np.testing.assert_allclose(run.f_m, 0.5 * written["force"], atol=digits)
    assert run.f_m.attrs["units"] == "N" and len(run.attrs["sha256"]) == 64


def test_objects_of_matlab_are_left_out_and_named(tmp_path):
    files.mat5_with_object(tmp_path / "a.mat", columns(), RATE)
    with pytest.raises(TypeError):
        scipy.io.whosmat(tmp_path / "a.mat")  # why the list of variables is not asked for
    assert left_out(tmp_path / "a.mat") == {"unnamed": "a MATLAB object"}
    files.mat73(tmp_path / "b.mat", columns(), RATE)
    assert left_out(tmp_path / "b.mat")["settings"] == "a MATLAB object (table)"


def test_objects_of_python_are_left_out_and_named(tmp_path):
    np.savez(tmp_path / "a.npz", f=np.arange(100.0) ** 2, fs=10.0, meta=np.array({"a": 1}, dtype=object))
    assert left_out(tmp_path / "a.npz") == {"meta": "a Python object"}
    assert fl.identify.load(tmp_path / "a.npz").sizes["time"] == 100


def test_times_without_a_unit_are_read_in_the_one_that_agrees(tmp_path):
    scipy.io.savemat(tmp_path / "a.mat", {"t": np.arange(500) * 0.2, "f": np.arange(500.0) ** 0.5, "fs": 5000.0})
    assert float(fl.identify.load(tmp_path / "a.mat").time[1]) == pytest.approx(2e-4)


def test_a_table_of_weights_is_no_time_series(tmp_path):
    (tmp_path / "w.csv").write_text("mass [g],reading [mV]\n0,1.0\n50,3.5\n100,6.1\n")
    run = fl.identify.load(tmp_path / "w.csv", {"mass": "mass", "f_m": "reading"})
    assert run.mass.dims == ("row",) and run.mass.attrs["units"] == "kg" and run.f_m.attrs["units"] == "V"
    np.testing.assert_allclose(run.mass, [0, 0.05, 0.1])


def test_the_map_turns_unwraps_zeroes_and_moves(tmp_path):
    counts = (np.arange(4000.0) * 3.0 + 100) % 4096
    wave = np.sin(2 * np.pi * 10 * np.arange(4000) / 1000.0)
    np.savez(tmp_path / "a.npz", encoder=counts, wave=wave, sr=1000.0)
    assert next(c for c in fl.identify.channels(tmp_path / "a.npz").channels if c.name == "encoder").wraps == 2
    told = {
        "position": {"column": "encoder", "wrap": 4096, "scale": 1e-6, "gives": "m", "zero_s": [0.0, 0.001]},
        "f_m": {"column": "wave", "sign": -1, "delay_s": 0.0125},
    }
    run = fl.identify.load(tmp_path / "a.npz", told)
    np.testing.assert_allclose(run.position, 3e-6 * np.arange(4000), atol=1e-12)
    late = -np.sin(2 * np.pi * 10 * (np.arange(4000) / 1000.0 + 0.0125))
    np.testing.assert_allclose(run.f_m[20:-40], late[20:-40], atol=1e-5)


def test_a_ragged_header_and_two_rows_of_names(tmp_path):
    (tmp_path / "a.txt").write_text("Time Px SF\n" + "\n".join(f"{k / 100} {k} 1 {k}.5 7" for k in range(9)))
    assert [each.name for each in read_table(tmp_path / "a.txt").channels] == ["Time", "Px", "SF", "3", "4"]
    (tmp_path / "b.csv").write_text('"Force",,"Stage"\n"x","y","x"\n' + "\n".join(f"{k},{k},{k}" for k in range(9)))
    assert [each.name for each in read_table(tmp_path / "b.csv").channels] == ["Force x", "Force y", "Stage x"]


def test_clipping_is_seen_and_a_turning_signal_is_not_clipped(tmp_path):
    time = np.arange(20000) / 1000.0
    wave = np.sin(2 * np.pi * 1.7 * time) + 0.01 * np.random.default_rng(1).normal(size=time.size)
    quiet = np.rint(3 * np.random.default_rng(2).normal(size=time.size))
    np.savez(tmp_path / "a.npz", t=time, good=wave, cut=np.minimum(wave, 0.8), quiet=quiet)
    found = {each.name: each.clipped for each in fl.identify.channels(tmp_path / "a.npz").channels}
    assert found["good"] == 0 and found["quiet"] == 0
    assert found["cut"] == pytest.approx(np.mean(wave > 0.8), rel=0.02)


def test_a_missing_extra_is_one_line(tmp_path, monkeypatch):
    import sys

    files.tdms(tmp_path / "a.tdms", columns(), RATE)
    monkeypatch.setitem(sys.modules, "nptdms", None)
    said = complaint(tmp_path / "a.tdms")
    assert "npTDMS (LGPL) is missing; install with: " in said and said.endswith("'frictionloop[identify]'")


def test_what_is_left_out_and_what_is_assumed_is_told(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, force=np.sin(np.arange(5000.0)), fast=np.cos(np.arange(9000.0)), fs=5000.0)
    (left,) = fl.identify.findings_of(fl.identify.load(path).attrs)
    assert (left.code, left.where.channel, left.more["reason"]) == ("LEFT-OUT", "force", "5000 samples")
    named = fl.identify.load(path, {"f_m": {"column": "force"}})
    (taken,) = fl.identify.findings_of(named.attrs)
    assert (taken.code, taken.value) == ("TAKEN-FOR", "N")
    told = fl.identify.load(path, {"f_m": {"column": "force", "unit": "V"}})
    assert fl.identify.findings_of(told.attrs) == []


@pytest.mark.parametrize("column", ["way", "way_mm", "Way [mm]"])
def test_a_column_is_found_as_its_header_spells_it(tmp_path, column):
    """The unit at the end of a header is not part of the name; a map may repeat it."""
    np.savetxt(
        tmp_path / "a.csv", np.arange(600.0).reshape(200, 3), delimiter=",", header="time_ms,way_mm,f_n", comments=""
    )
    chart = {"position": {"column": column}, "f_m": {"column": "f_n"}}
    run = fl.identify.load(tmp_path / "a.csv", chart)
    assert run.position.attrs["units"] == "m" and run.position.values[:2] == pytest.approx([1e-3, 4e-3])
