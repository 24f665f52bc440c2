"""The screens of identify on a standard lab, as they were last looked at; FRICTIONLOOP_GOLDEN=1 writes them anew."""

from __future__ import annotations

import os

import numpy as np
import pytest
import simulated_lab
from golden import check_screen
from scipy.constants import g as GRAVITY

import frictionloop as fl


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """A lab whose weights are bent and whose hits come twice, so that there is something to find."""
    folder = tmp_path_factory.mktemp("lab")
    path = simulated_lab.lab(folder, "file.npz", seed=5)
    grams = np.array([0.0, 50, 100, 150, 200, 150, 100, 50, 0])
    force = 1e-3 * grams * GRAVITY
    volts = 3.0 * force + 0.02 * force**2 + 1e-4 * np.random.default_rng(0).normal(size=force.size)
    np.savez(folder / "again.npz", mass=1e-3 * grams, f_m=volts)
    channels = 'channels.mass = { column = "mass", unit = "kg" }\nchannels.f_m = { column = "f_m", unit = "V" }\n'
    entry = f'\n[[recording]]\nkind = "weights"\nfiles = ["again.npz"]\n{channels}'
    path.write_text(path.read_text() + entry)
    return path


@pytest.fixture(scope="module")
def bench(lab):
    return fl.identify.bench(lab)


def test_bench(bench):
    check_screen("identify-bench", str(bench))
    everything = bench.to_json() + bench.to_html()
    assert all(each.code in everything and str(each) for each in bench.findings)


def test_channels(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    time = np.arange(4000) / 1e3
    force = (0.5 + 0.1 * np.sin(9 * time)) * np.where(time % 2 < 1, 1, -1)
    counts = np.floor(3.0 * np.arange(4000) + 100) % 4096
    force[77] = np.nan
    cut = np.minimum(np.sin(11 * time) + 1e-3 * np.random.default_rng(1).normal(size=time.size), 0.8)
    head, columns = "time_s,Ft [N],counts,gauge [V]", np.c_[time, force, counts, cut]
    np.savetxt("slide.csv", columns, delimiter=",", header=head, comments="")
    os.utime("slide.csv", (1.7e9, 1.7e9))
    found = fl.identify.channels("slide.csv")
    check_screen("identify-channels", str(found))
    assert {each.code for each in found.findings} == {"DATA-GAPS", "CLIPPED", "COUNTER-WRAPS", "SIGN-DOUBT"}
    assert fl.identify.read_map(_written(found)).channels["channel_1"].column == "Ft"


def _written(found):
    found.write_map("map.toml")
    return "map.toml"


def test_compare(bench, tmp_path):
    before, after = tmp_path / "before.json", tmp_path / "after.json"
    before.write_text(bench.to_json())
    q = bench.measured["sensor.q"]
    after.write_text(bench.to_json().replace(repr(q.value), repr(1.1 * q.value)))
    found = fl.identify.compare(before, after)
    check_screen("identify-compare", str(found))
    (changed,) = found.findings
    assert changed.more["path"] == "sensor.q" and changed.value == pytest.approx(10.0)
    assert fl.identify.certified_corners(before) == bench.corners


def test_run():
    with fl.connect("sim:") as device:
        found = fl.identify.run("quiet", device)
    check_screen("identify-run", str(found.saved_at("quiet.h5")))
    assert (found.samples, found.lost_samples) == (50_000, 0)
