"""A run as a Dataset and as a file: everything comes back, and nothing is lost on the way."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import textwrap

import h5py
import numpy as np
import pytest
import xarray as xr

import frictionloop as fl
from frictionloop.quantities.code_version import package_version

SYSTEM = fl.paper().evolve({"controller.kp": 20.0, "disturbance": fl.Steps(times_s=(0.0, 0.1), levels_n=(0.1, 0.2))})
RUN = fl.simulate(SYSTEM, 0.2, seed=3)


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "run.h5"
    fl.save(RUN, path)
    return path


def complaint(function, *arguments):
    with pytest.raises(fl.FrictionloopError) as failure:
        function(*arguments)
    assert "\n" not in str(failure.value)
    return str(failure.value)


def test_what_a_run_holds():
    assert dict(RUN.sizes) == {"time": 1000}
    units = {"f_r": "N", "f_a": "N", "f_m": "N", "u": "N", "a": "um", "d": "N", "saturated": "1", "time": "s"}
    assert {name: RUN[name].attrs["units"] for name in RUN.variables} == units
    assert all(RUN[name].attrs["long_name"] for name in RUN.variables)
    assert RUN["saturated"].dtype == bool
    assert RUN["f_a"].dtype == np.float64
    assert RUN.attrs["seed"] == 3
    assert RUN.attrs["source"] == "simulated"
    assert RUN.attrs["version"] == package_version() == fl.__version__
    assert fl.system_of(RUN) == SYSTEM


def test_the_file_gives_back_the_same_bits_types_and_attributes(saved):
    back = fl.load(saved)
    xr.testing.assert_identical(back, RUN)
    for name in RUN.variables:
        assert back[name].dtype == RUN[name].dtype
    assert fl.system_of(back) == SYSTEM
    again = fl.simulate(fl.system_of(back), 0.2, int(back.attrs["seed"]))
    xr.testing.assert_identical(again, RUN)


@pytest.mark.parametrize("seed", [0, 2**63, 2**64 - 1])
def test_any_seed_survives_the_file(tmp_path, seed):
    run = fl.simulate(SYSTEM, 0.01, seed)
    fl.save(run, tmp_path / "run.h5")
    assert int(fl.load(tmp_path / "run.h5").attrs["seed"]) == seed


def test_a_sweep_survives_the_file(tmp_path):
    grid = fl.sweep(fl.paper(), {"controller.kp": [1.0, 2.0], "plate.kind": ["lowpass"]}, 0.01, seeds=[5, 9])
    fl.save(grid, tmp_path / "sweep.h5")
    xr.testing.assert_identical(fl.load(tmp_path / "sweep.h5"), grid)


def test_other_tools_read_the_file(saved):
    with h5py.File(saved) as file:
        np.testing.assert_array_equal(file["f_a"][:], RUN["f_a"].values)
        np.testing.assert_array_equal(file["saturated"][:].astype(bool), RUN["saturated"].values)
        np.testing.assert_array_equal(file["time"][:], RUN["time"].values)
        assert file["a"].attrs["units"] == "um"
        assert file.attrs["schema"] == 1
        assert '"kp":20.0' in file.attrs["system"]
    with xr.open_dataset(saved, engine="h5netcdf") as run:
        xr.testing.assert_equal(run.load(), RUN)


def test_a_newer_version_is_refused_by_name(saved):
    with h5py.File(saved, "a") as file:
        file.attrs["schema"] = 2
    assert complaint(fl.load, saved).startswith(f"{saved}: schema = 2: ")


def test_a_truncated_file_is_one_line(saved):
    whole = saved.read_bytes()
    for keep in (len(whole) - 100, len(whole) // 2, 100, 0):
        saved.write_bytes(whole[:keep])
        assert complaint(fl.load, saved).startswith(f"{saved}: cannot be read")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_may_not_be_written(tmp_path):
    tmp_path.chmod(0o500)
    assert "cannot be written" in complaint(fl.save, RUN, tmp_path / "run.h5")


FULL_DISK = """
    import resource, signal, sys
    import frictionloop as fl

    run = fl.simulate(fl.paper(), 1.0)
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # writing past the limit then fails as on a full disk
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, resource.RLIM_INFINITY))
    try:
        fl.save(run, sys.argv[1])
    except fl.FrictionloopError as error:
        print(error)
"""


@pytest.mark.slow
def test_a_full_disk_keeps_the_old_file(saved):
    pytest.importorskip("resource")
    before = saved.read_bytes()
    told = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(FULL_DISK), str(saved)], capture_output=True, text=True, check=True
    )
    assert told.stdout.startswith(f"{saved}: cannot be written"), told
    assert told.stdout.count("\n") == 1
    assert told.stderr == ""
    assert saved.read_bytes() == before
    assert os.listdir(saved.parent) == [saved.name]


def test_saving_again_replaces_the_file(saved):
    shorter = fl.simulate(SYSTEM, 0.1, seed=4)
    fl.save(shorter, saved)
    xr.testing.assert_identical(fl.load(saved), shorter)
    assert os.listdir(saved.parent) == [saved.name]


def test_a_failure_on_the_way_keeps_the_old_file(saved, monkeypatch):
    def half(path, content):
        with path.open("wb") as file:
            file.write(content[: len(content) // 2])
        raise OSError(errno.ENOSPC, "No space left on device")

    before = saved.read_bytes()
    monkeypatch.setattr("pathlib.Path.write_bytes", half)
    assert "No space left on device" in complaint(fl.save, RUN, saved)
    assert saved.read_bytes() == before
    assert os.listdir(saved.parent) == [saved.name]


def test_a_run_as_a_table_comes_back_as_a_recording(tmp_path):
    """The table's columns are read by their names, with rate and unit found in its header."""
    fl.save(RUN, tmp_path / "run.csv")
    recording = fl.Recording(path=str(tmp_path / "run.csv"), column="f_a")
    system = fl.feasible().evolve(disturbance=recording, setpoint=fl.Constant(offset_n=1.4))
    again = fl.simulate(system, RUN.sizes["time"] / 5000.0 - 1e-3)
    np.testing.assert_allclose(again.d, RUN.f_a[: again.sizes["time"]], rtol=1e-12)


def test_a_sweep_as_a_table_has_a_row_per_run(tmp_path):
    grid = fl.sweep(fl.feasible(), {"controller.kp": [1.0, 2.0], "controller.ki": [1.0, 2.0, 3.0]}, 0.02, 2)
    fl.save(grid, tmp_path / "grid.csv")
    header, *rows = (tmp_path / "grid.csv").read_text().splitlines()
    assert header == "controller.kp [N/N],controller.ki [1/s],seed,r2_identity,rms_error [N],saturation_index"
    assert len(rows) == 12
    point = grid.isel({"controller.kp": 1, "controller.ki": 2, "seed": 1})
    assert [float(cell) for cell in rows[-1].split(",")[3:]] == [float(value) for value in point.data_vars.values()]
