"""Large files are read by the block: the same samples, the same glance, the same bench as from the memory."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import recorded_files as files
from three_modes import TRUE, plate

import frictionloop as fl
from frictionloop.identification import recording_file
from frictionloop.identification.file_overview import first_look
from frictionloop.identification.project_analysis import analyse
from frictionloop.identification.project_entry_result import Sensor
from frictionloop.identification.project_file import Take
from frictionloop.recordings import contents, text_tables
from frictionloop.recordings.file_opening import _read, read_contents

RATE = 8000.0
forget = _read.cache_clear
BY_THE_BLOCK = ("time.csv", "european.csv", "file.h5", "seven.mat", "file.wav", "file.tdms")


@pytest.fixture
def small_blocks(monkeypatch):
    monkeypatch.setattr(contents, "LARGE_BYTES", 1000)
    forget()
    monkeypatch.setattr(contents, "BLOCK", 300)
    monkeypatch.setattr(recording_file, "ROWS", 2**14)


def columns(samples=4321):
    draw = np.random.default_rng(4)
    clipped = np.clip(np.cumsum(draw.normal(size=samples)), -20, 20)
    return {"force": 0.01 * clipped, "other": np.sin(np.arange(samples) / 50)}


@pytest.mark.parametrize("name", [name for name in files.FORMATS if name in BY_THE_BLOCK])
def test_blocks_give_what_the_whole_file_gives(tmp_path, name, monkeypatch):
    files.FORMATS[name](tmp_path / name, columns(), RATE)
    at_once, seen = read_contents(tmp_path / name), fl.identify.channels(tmp_path / name)
    monkeypatch.setattr(contents, "LARGE_BYTES", 1000)
    forget()
    monkeypatch.setattr(contents, "BLOCK", 300)
    parts = read_contents(tmp_path / name)
    lines = {line.name: line.samples for line in parts.channels}
    assert all(isinstance(samples, contents.Stored) for samples in lines.values() if samples.size > 300)
    for line in at_once.channels:
        np.testing.assert_array_equal(np.asarray(lines[line.name]), line.samples)
        np.testing.assert_array_equal(lines[line.name][250:1250], line.samples[250:1250])
    again = fl.identify.channels(tmp_path / name)
    assert again.rate_hz == pytest.approx(seen.rate_hz, rel=1e-9)
    for one, other in zip(seen.channels, sorted(again.channels, key=lambda c: names(seen).index(c.name)), strict=True):
        assert other.rms == pytest.approx(one.rms, rel=1e-12)
        # A run at the end of the range that two blocks share may be too short in one of them.
        assert other._replace(rms=0, clipped=0) == one._replace(rms=0, clipped=0)
        assert other.clipped == pytest.approx(one.clipped, rel=0.05)
    assert any(each.clipped > 0.01 for each in again.channels)


def names(preview):
    return [each.name for each in preview.channels]


def test_gaps_of_the_times_are_found_across_blocks(tmp_path, small_blocks):
    rows = np.delete(np.arange(5000), [299, 300, 2000])
    table = np.column_stack([rows / RATE, np.sin(rows)])
    np.savetxt(tmp_path / "gaps.csv", table, delimiter=",", header="time_s,f", comments="")
    assert fl.identify.channels(tmp_path / "gaps.csv").gaps == ((298, 2), (1997, 1))


def test_a_large_table_with_blank_lines_is_read_and_it_is_told(tmp_path, small_blocks, monkeypatch):
    monkeypatch.setattr(text_tables, "CHUNK", 999)
    rows = ["time_s,f", *(f"{k / RATE},{k % 7}" for k in range(2000))]
    rows[1000:1000] = [""]
    (tmp_path / "blank.csv").write_text("\n".join(rows))
    found = read_contents(tmp_path / "blank.csv")
    assert np.asarray(found.channels[1].samples).tolist() == [k % 7 for k in range(2000)]
    assert [(each.value, each.where.channel) for each in found.findings] == [(1, "line 1001")]


def project(kind, name, **more):
    return Take(kind=kind, files=(name,), channels={"f_m": {"column": "f", "unit": "V"}}, **more)


def test_hits_of_a_long_recording_are_those_of_a_short_one(tmp_path, monkeypatch):
    run = plate(hits=12)
    files.hdf5(tmp_path / "long.h5", {"f": run.f_m.values}, 100e3)
    take = project("hits", "long.h5")
    whole = analyse(take, tmp_path, Sensor())
    monkeypatch.setattr(contents, "LARGE_BYTES", 1000)
    forget()
    monkeypatch.setattr(contents, "BLOCK", 2**12)
    monkeypatch.setattr(recording_file, "ROWS", 2**15)
    monkeypatch.setattr(recording_file, "CALM_S", 0.01)
    parts = analyse(take, tmp_path, Sensor())
    assert len(parts.rows) == len(whole.rows) == 13
    assert [row[1:3] for row in parts.rows] == [row[1:3] for row in whole.rows]
    for part in (whole, parts):
        low, high = part.measured[0].interval(0.999)
        assert low < TRUE[0][0] < high
    assert parts.measured[0].value == pytest.approx(whole.measured[0].value, abs=2 * whole.measured[0].error)


def test_weights_and_quiet_of_a_long_recording(tmp_path, monkeypatch):
    draw = np.random.default_rng(1)
    mass = np.repeat([0.0, 0.1, 0.2, 0.3, 0.2, 0.1, 0.0], 4000)
    reading = 2.0 * 9.80665 * mass + 1e-3 * draw.normal(size=mass.size)
    files.hdf5(tmp_path / "w.h5", {"mass": mass, "f": reading}, RATE)
    quiet = 1e-3 * draw.normal(size=40000) * np.repeat([9, 1, 1, 1, 9], 8000)
    files.hdf5(tmp_path / "q.h5", {"f": quiet}, RATE)
    monkeypatch.setattr(contents, "LARGE_BYTES", 1000)
    forget()
    monkeypatch.setattr(contents, "BLOCK", 2**11)
    monkeypatch.setattr(recording_file, "ROWS", 2**13)
    channels = {"f_m": {"column": "f", "unit": "V"}, "mass": {"column": "mass", "unit": "kg"}}
    take = Take(kind="weights", files=("w.h5",), settle_s=0.1, channels=channels, gravity_m_s2=9.80665)
    slope = analyse(take, tmp_path, Sensor()).measured[0]
    assert slope.value == pytest.approx(2.0, rel=1e-4)
    density = analyse(project("quiet", "q.h5"), tmp_path, Sensor()).measured[0]
    assert density.value == pytest.approx(1e-3 * np.sqrt(2 / RATE), rel=0.03)
    given = analyse(project("quiet", "q.h5", interval_s=(1.5, 3.5)), tmp_path, Sensor())
    assert given.measured[0].value == pytest.approx(density.value, rel=0.05)
    assert "1.5 to 3.5 s" in dataclasses.asdict(given.measured[0])["how"]


def test_a_first_look_at_a_large_table_is_one_all_along_it(tmp_path, monkeypatch):
    monkeypatch.setattr(contents, "LARGE_BYTES", 1000)
    forget()
    rising = {"force": np.linspace(0, 1, 300_000), "other": np.sin(np.arange(300_000) / 50)}
    files.csv(tmp_path / "a.csv", rising, RATE)
    look = first_look(tmp_path / "a.csv")
    force, other = look.traces
    assert (force.name, other.name) == ("force", "other")
    np.testing.assert_allclose(force.row / 300_000, (force.low + force.high) / 2, atol=1e-3)
    assert force.low[0] < 0.01 and force.high[-1] > 0.99 and other.high.min() > 0.9
    assert look.rate_hz == RATE
    fl.plot(look, tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 5000


@pytest.mark.parametrize("samples", [57, 100, 14451])
def test_a_first_look_at_a_short_file_sees_every_sample(tmp_path, samples):
    for row in (0, samples // 3, samples - 2, samples - 1):
        values = np.zeros(samples)
        values[row] = 1.0
        np.savez(tmp_path / "a.npz", f=values, fs=1e3)
        look = first_look(tmp_path / "a.npz")
        assert look.traces[0].high.max() == 1.0 and look.said.endswith("all samples")
        (axes,) = fl.plot(look).axes
        assert look.rate_hz == 1e3 and axes.get_xlabel() == "time (s)"
        assert axes.get_xlim()[1] < samples / 1e3


def test_a_first_look_leaves_out_what_never_changes_and_says_so(tmp_path):
    at = np.cumsum(1 + 0.5 * (np.arange(200) % 2)) / 50  # uneven
    columns = [at, *(np.sin((k + 1) * at) for k in range(25)), 0 * at]
    names = ["Time", *(f"c{k}" for k in range(25)), "still"]
    np.savetxt(tmp_path / "a.csv", np.transpose(columns), delimiter=",", header=",".join(names), comments="")
    look = first_look(tmp_path / "a.csv")
    assert [trace.name for trace in look.drawn()] == [f"c{k}" for k in range(24)]
    axes = fl.plot(look).axes
    assert len(axes) == 24 and axes[-1].get_xlabel() == "sample"
    assert first_look(tmp_path / "a.csv", 50.0).rate_hz is None
