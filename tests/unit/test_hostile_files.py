"""Files that are damaged or made to harm: one line each, in little time and memory, and no other file is read."""

from __future__ import annotations

import io
import os
import re
import struct
import time
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pytest
import recorded_files as files
import scipy.io
import xarray as xr

import frictionloop as fl
from frictionloop.cli import main
from frictionloop.quantities.file_integrity import SEAL_BYTES
from frictionloop.recordings import hdf5_checks
from frictionloop.recordings.force_channel import read_recording
from frictionloop.rendering.hjif import read_hjif

BASE = fl.paper()


@pytest.fixture(scope="module")
def run():
    return fl.simulate(BASE, 0.02)


@pytest.fixture
def saved(tmp_path, run):
    path = tmp_path / "run.h5"
    fl.save(run, path)
    return path


@pytest.fixture
def unsealed(saved):
    """A file of another program: nothing says what its content was."""
    saved.write_bytes(saved.read_bytes()[:-SEAL_BYTES])
    return saved


def refused(path, why, limit_s=10.0):
    start = time.process_time()
    with pytest.raises(fl.FrictionloopError, match=why) as error:
        fl.load(path)
    assert time.process_time() - start < limit_s
    assert str(error.value).startswith(str(path)) and "\n" not in str(error.value)


def test_any_changed_byte_is_seen(saved, run):
    """Of old, some changed values were loaded as if they were right, and some bytes kept HDF5 busy for ever."""
    content = saved.read_bytes()
    draw = np.random.default_rng(0)
    for place in draw.integers(0, len(content) - SEAL_BYTES, 100):
        changed = bytearray(content)
        changed[place] ^= 1 << draw.integers(8)
        saved.write_bytes(changed)
        refused(saved, "is damaged")
    saved.write_bytes(content)
    xr.testing.assert_identical(fl.load(saved), run)


@pytest.mark.parametrize("cut", [1, 20, SEAL_BYTES - 4])
def test_a_file_cut_within_its_seal_is_damaged(saved, cut):
    saved.write_bytes(saved.read_bytes()[:-cut])
    refused(saved, "is damaged")


def test_other_programs_read_a_sealed_file_and_what_they_change_loads(saved):
    with h5py.File(saved, "r+") as file:
        file.attrs["note"] = "mine"
    assert fl.load(saved).attrs["note"] == "mine"


def test_a_file_that_keeps_hdf5_busy(unsealed, monkeypatch):
    assert fl.load(unsealed).sizes["time"] == 100
    monkeypatch.setattr(hdf5_checks, "LOOK_S", 0.01)
    hdf5_checks._complaint.cache_clear()
    refused(unsealed, r"is damaged \(read for 0.01 s\)$")


def test_half_a_file_and_none(saved):
    saved.write_bytes(saved.read_bytes()[:3000])
    refused(saved, "cannot be read")
    saved.write_bytes(b"")
    refused(saved, "cannot be read")


@pytest.mark.parametrize("value", ["abc", 1.5, [1, 2], b"\xff", np.array([], float)], ids=repr)
def test_a_schema_that_is_no_number(unsealed, value):
    with h5py.File(unsealed, "r+") as file:
        file.attrs["schema"] = value
    refused(unsealed, "schema = |cannot be read")


@pytest.mark.parametrize("system", ["[1, 2]", "[" * 20_000, '"abc"', 7, "{}"], ids=lambda each: str(each)[:8])
def test_a_system_that_is_none(run, system):
    with pytest.raises(fl.FrictionloopError) as error:
        fl.system_of(run.assign_attrs(system=system))
    assert "\n" not in str(error.value)


def made(path, how):
    """Write a file that takes its values, or all the memory, from elsewhere."""
    other = path.with_name("other.h5")
    with h5py.File(other, "w") as file:
        file["secret"] = np.arange(100.0)
    with h5py.File(path, "w") as file:
        file["time"] = np.arange(100.0) / 100
        if how == "link":
            file["force"] = h5py.ExternalLink(str(other), "secret")
        elif how == "storage":
            file.create_dataset("force", (100,), "f8", external=[(str(other), 0, 800)])
        elif how == "virtual":
            layout = h5py.VirtualLayout((100,), "f8")
            layout[:] = h5py.VirtualSource(str(other), "secret", (100,))
            file.create_virtual_dataset("force", layout)
        elif how == "bomb":
            file.create_dataset("force", (10**9,), "f8", chunks=(10**6,), compression="gzip")
        else:
            group = file.create_group("many")
            for k in range(hdf5_checks.MOST_OBJECTS + 1):
                group.create_group(str(k))


WRONG = {
    "link": "'/force': must not be in",
    "storage": "'/force': must not be in another file",
    "virtual": "'/force': must not be in another file",
    "bomb": "expands to 8 GB",
    "objects": "objects > 10000",
}


@pytest.mark.parametrize("how", WRONG)
def test_what_is_made_to_harm(tmp_path, how):
    path = tmp_path / "made.h5"
    made(path, how)
    refused(path, WRONG[how])
    with pytest.raises(fl.FrictionloopError, match=WRONG[how]):
        read_recording(fl.Recording(path=str(path), column="force"), 100.0)


def bomb(path):
    """Write a small file that says it holds 8 GB."""
    if path.suffix == ".npz":
        head = io.BytesIO()
        np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (10**9,)})
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed:
            packed.writestr("force.npy", head.getvalue())
        content = path.read_bytes()
        entry = content.rindex(b"PK\x01\x02")  # the directory, which tells sizes; 24: bytes when unpacked
        path.write_bytes(content[: entry + 24] + (4 * 10**9).to_bytes(4, "little") + content[entry + 28 :])
    else:
        scipy.io.savemat(path, {"force": np.zeros((2, 3))})
        path.write_bytes(path.read_bytes().replace(struct.pack("<ii", 2, 3), struct.pack("<ii", 2, 5 * 10**8)))


@pytest.mark.parametrize("ending", [".npz", ".mat"])
def test_recordings_that_are_made_to_fill_the_memory(tmp_path, ending):
    path = tmp_path / f"bomb{ending}"
    bomb(path)
    said = r"expands to .* GB: must be at most 100 x its size$"
    with pytest.raises(fl.FrictionloopError, match=said) as error:
        fl.identify.load(path)
    assert "\n" not in str(error.value)


def test_a_table_of_too_many_columns(tmp_path):
    """Names were once looked for among all names before: 100 000 columns took minutes."""
    path = tmp_path / "wide.csv"
    path.write_text("time,force\n" + "0," * 100_000 + "\n")
    start = time.process_time()
    with pytest.raises(fl.FrictionloopError, match=r"wide.csv: columns = 10000\d: must be at most 10000$"):
        fl.identify.load(path)
    assert time.process_time() - start < 5.0


DEEP = 20_000
TOML = {
    "arrays": "a = " + "[" * DEEP + "]" * DEEP,
    "tables": "a = " + "{a = " * DEEP + "1" + "}" * DEEP,
    "keys": ".".join(["a"] * DEEP) + " = 1",
    "quoted keys": " . ".join(['"a"'] * DEEP) + " = 1",
    "header": "[" + ".".join(["a"] * DEEP) + "]",
    "one long word": "a" * 900_000,
    "large": "#" * 2_000_000,
    "digits": "a = " + "1" * 5000,
}


@pytest.mark.parametrize("how", TOML)
def test_toml(tmp_path, how):
    path = tmp_path / "bench.toml"
    path.write_text('preset = "paper"\n' + TOML[how])
    start = time.process_time()
    with pytest.raises(fl.FrictionloopError, match=rf"^{re.escape(str(path))}: ") as error:
        fl.read_toml(path)
    assert time.process_time() - start < 5.0
    assert "\n" not in str(error.value) and len(str(error.value)) < 300


def test_a_file_of_thousands_of_unknown_names_names_twenty(tmp_path):
    path = tmp_path / "bench.toml"
    path.write_text('preset = "bench"\n[controller]\n' + "".join(f"x{k} = 1\n" for k in range(16_000)))
    start = time.process_time()
    with pytest.raises(fl.FrictionloopError) as error:
        fl.read_toml(path)
    assert time.process_time() - start < 5.0
    first, *named, last = str(error.value).splitlines()
    assert first.endswith("16000 unknown parameters:") and len(named) == 20 and last == "  and 15980 more"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes with names as POSIX has them")
@pytest.mark.parametrize("read", [fl.read_toml, read_hjif, fl.identify.certified_corners], ids=lambda f: f.__name__)
def test_what_is_no_file_is_not_waited_for(tmp_path, read):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", Path("/dev/zero")):
        with pytest.raises(fl.FrictionloopError, match=f"^{path}: is no file$"):
            read(path)


# What is wrong with a recording is one line, and nothing that is there already is lost.


RATE = 1000.0


def noise(samples=5000):
    return 1e-3 * np.random.default_rng(1).normal(size=samples)


def clipped():
    return np.minimum(noise() + 0.1 * np.sin(np.arange(5000) / 300), 0.08)


def stretch():
    values = noise()
    values[1000:1500] = np.nan
    return values


def encrypted(path, columns, rate):
    path.write_bytes(np.random.default_rng(2).bytes(4096))


def truncated(path, columns, rate):
    files.mat5(path, columns, rate)
    path.write_bytes(path.read_bytes()[:-3000])


def unequal(path, columns, rate):
    scipy.io.savemat(path, {"f": noise(5000), "load": noise(4000), "fs": rate})


def two_rates(path, columns, rate):
    scipy.io.savemat(path, {"f": noise(5000), "time": np.arange(5000) / 990.0, "fs": rate})


CASES = {
    "NaN stretch": (files.mat5, stretch(), "at row 1000 = nan: must be a number; 500 are none"),
    "three samples": (files.mat5, noise(3), "quiet: rows = 3"),
    "all zero": (files.mat5, 0 * noise(), "0 throughout"),
    "clipped": (files.mat5, clipped(), "f_m: share clipped = "),
    "encrypted": (encrypted, None, "damaged or encrypted"),
    "truncated": (truncated, noise(), "damaged or encrypted"),
    "two rates": (two_rates, None, "rate_hz = "),
    "missing channel": (files.mat5, noise(), "did you mean f"),
    "unequal lengths": (unequal, None, "samples of channels = {'f_m': 5000, 'load': 4000}"),
}


@pytest.mark.parametrize("case", CASES)
def test_each_is_one_line_that_names_the_file(tmp_path, capsys, case):
    write, values, says = CASES[case]
    write(tmp_path / "quiet.mat", {"f": values}, RATE)
    column = "ff" if case == "missing channel" else "f"
    more = 'channels.load = { column = "load", unit = "V" }\n' if case == "unequal lengths" else ""
    (tmp_path / "lab.toml").write_text(
        f'[[recording]]\nkind = "quiet"\nfiles = ["quiet.mat"]\nchannels.f_m = {{ column = "{column}", unit = "V" }}\n'
        + more
    )
    (tmp_path / "my.toml").write_text("mine")
    with pytest.raises(SystemExit) as left:
        main(["identify", "bench", str(tmp_path / "lab.toml"), "--out", str(tmp_path / "my.toml")])
    said = capsys.readouterr().err
    assert left.value.code == 2 and said.count("\n") == 1 and "quiet.mat" in said
    assert says in said, said
    assert (tmp_path / "my.toml").read_text() == "mine"


@pytest.mark.slow
def test_an_older_certificate_is_kept(tmp_path):
    from frictionloop.report.certificate import write_certificate

    np.savez(tmp_path / "q.npz", f=noise(20000), fs=RATE)
    (tmp_path / "lab.toml").write_text(
        '[[recording]]\nkind = "quiet"\nfiles = ["q.npz"]\nchannels.f_m = { column = "f", unit = "V" }\n'
    )
    found = fl.identify.bench(tmp_path / "lab.toml")
    (tmp_path / "c.html").write_text("first")
    (tmp_path / "c-1.html").write_text("older")
    assert write_certificate(found, tmp_path / "c.html") == tmp_path / "c-2.html"
    assert (tmp_path / "c-1.html").read_text() == "older" and (tmp_path / "c-2.html").read_text() == "first"
