"""What is wrong with a recording is one line, and nothing that is there already is lost."""

from __future__ import annotations

import numpy as np
import pytest
import recorded_files as files
import scipy.io

import frictionloop as fl
from frictionloop.cli import main

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
