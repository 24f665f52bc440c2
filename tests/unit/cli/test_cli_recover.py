"""``frictionloop device recover``, long runs, and a run that is given no file, in a user's home."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.device import run_accuracy
from frictionloop.device.device_run import check_folder
from frictionloop.loop.growing_file import Column, Spool

COLUMNS = {"f_m": Column("f8", {"units": "N", "long_name": "measured force"})}
NOBODY = 65534
FORCES = np.linspace(0.0, 1.0, 7000)


@pytest.fixture
def partial(tmp_path):
    """What a recording leaves behind whose process was killed."""
    spool = Spool(tmp_path / "run.h5", COLUMNS, 2e-4, {"schema": 1, "source": "device"}, ("lost_samples",))
    spool.append({"f_m": FORCES}, {"lost_samples": 3})
    left = tmp_path / "kept" / spool.partial.name
    left.parent.mkdir()
    shutil.copy(spool.partial, left)
    spool.drop()
    return left.rename(tmp_path / left.name)


def test_it_says_what_a_file_holds_and_writes_it(frictionloop, partial):
    before = partial.read_bytes()
    found = frictionloop("device", "recover", partial.name, "--json").json()
    assert (found["samples"], found["duration_s"], found["source"]) == (7000, pytest.approx(1.4), "device")
    assert (found["lost_samples"], found["damaged_samples"], found["path"]) == (3, 0, "run.h5")
    assert [(each["code"], each["value"]) for each in found["findings"]] == [("SAMPLES-LOST", 3)]
    np.testing.assert_array_equal(fl.load("run.h5").f_m, FORCES)
    assert partial.read_bytes() == before
    assert fl.device.recover(partial, "mended.h5").path == "mended.h5"
    assert fl.load("mended.h5").sizes["time"] == 7000


def test_what_cannot_be_recovered_is_one_line(frictionloop, partial):
    fl.save(fl.simulate(fl.paper(), 0.02), "whole.h5")
    Path("text.h5").write_text("no HDF5")
    wrong = {
        ("none.h5", "--out", "o.h5"): "none.h5: cannot be read (no such file)",
        ("whole.h5", "--out", "o.h5"): "whole.h5: is no unfinished recording",
        ("text.h5", "--out", "o.h5"): "text.h5: cannot be read",
        ("whole.h5",): "file = 'whole.h5': must be named NAME.partial-",
        (partial.name, "--out", partial.name): "must be another file than the one to recover",
        (partial.name, "--out", "o.txt"): "must end in .h5",
    }
    for tokens, said in wrong.items():
        answer = frictionloop("device", "recover", *tokens)
        assert answer.code == 2 and said in answer.err and answer.err.count("\n") == 1
    Path("run.h5").write_text("mine")
    assert "--out = 'run.h5': must be a new file" in frictionloop("device", "recover", partial.name).err
    assert Path("run.h5").read_text() == "mine"


@pytest.mark.slow
def test_of_a_long_run_the_last_part_is_scored(frictionloop, monkeypatch):
    monkeypatch.setattr(run_accuracy, "SCORED_S", 0.2)
    found = frictionloop("device", "run", "sim:", "--duration-s", "0.5", "--out", "run.h5", "--json").json()
    assert (found["samples"], found["scored_samples"]) == (2500, 1000)
    assert fl.load("run.h5").sizes["time"] == 2500
    answer = frictionloop("device", "run", "sim:", "--duration-s", "0.5")
    assert answer.err == "error: duration_s = 0.5 s: must be above 0, at most 0.2; longer with out\n"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="users as POSIX has them")
def test_a_run_without_a_file_in_a_users_home():
    """The folder above a home belongs to root; as root, another user asks whether a file can be made there."""
    above = Path(tempfile.mkdtemp())
    home = above / "home"
    home.mkdir()
    is_root = os.geteuid() == 0
    if is_root:
        os.chown(home, NOBODY, NOBODY)
    above.chmod(0o555)
    child = os.fork()
    if not child:  # nothing but its exit code leaves it
        code = 1
        try:
            if is_root:
                os.setgid(NOBODY)
                os.setuid(NOBODY)
            os.chdir(home)
            check_folder(None)
            check_folder("run.h5")
            with pytest.raises(fl.FrictionloopError, match="cannot be written"):
                check_folder("../run.h5")
            code = 0
        finally:
            os._exit(code)
    _, status = os.waitpid(child, 0)
    above.chmod(0o755)
    shutil.rmtree(above)
    assert os.waitstatus_to_exitcode(status) == 0


def test_a_file_that_is_not_there_is_said_to_be_so(frictionloop):
    answer = frictionloop("device", "recover", "no.h5")
    assert (answer.code, answer.err) == (2, "error: no.h5: cannot be read (no such file)\n")
