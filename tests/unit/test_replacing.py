"""Files are replaced whole or not at all."""

from __future__ import annotations

import errno
import os

import pytest

from frictionloop.quantities import FrictionloopError, replacing, why_unwritable


@pytest.fixture
def old(tmp_path):
    path = tmp_path / "old.txt"
    path.write_text("old")
    return path


def only(path, text):
    """Assert that a folder holds this file with this text and nothing else."""
    assert path.read_text() == text
    assert os.listdir(path.parent) == [path.name]


def test_success_replaces(old):
    with replacing(old) as beside:
        assert beside.parent == old.parent  # a rename is atomic only within a file system
        beside.write_text("new")
        assert old.read_text() == "old"
    only(old, "new")


def test_a_new_file_appears(tmp_path):
    with replacing(str(tmp_path / "new.txt")) as beside:
        beside.write_text("new")
    only(tmp_path / "new.txt", "new")


def test_a_full_disk_keeps_the_old_file(old):
    def write(path):
        path.write_text("half")
        raise OSError(errno.ENOSPC, "No space left on device", str(path))

    with pytest.raises(FrictionloopError, match="cannot be written") as failure, replacing(old) as beside:
        write(beside)
    assert str(failure.value) == f"{old}: cannot be written (No space left on device); the old file is untouched"
    only(old, "old")


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, ValueError, FrictionloopError])
def test_any_failure_keeps_the_old_file_and_goes_on(old, interruption):
    with pytest.raises(interruption, match="on the way"), replacing(old) as beside:
        beside.write_text("half")
        raise interruption("on the way")
    only(old, "old")


def test_a_failing_rename_keeps_the_old_file(old, monkeypatch):
    def refuse(*_):
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr("pathlib.Path.replace", refuse)
    with pytest.raises(FrictionloopError, match="Permission denied"), replacing(old) as beside:
        beside.write_text("new")
    only(old, "old")


def test_a_missing_folder_is_one_line_and_speaks_of_no_old_file(tmp_path):
    path = tmp_path / "nowhere" / "new.txt"
    with pytest.raises(FrictionloopError) as failure, replacing(path) as beside:
        beside.write_text("new")
    assert str(failure.value) == f"{path}: cannot be written (No such file or directory)"


def test_why_a_folder_takes_no_file_leaving_nothing_in_it(tmp_path):
    assert why_unwritable(tmp_path) == ""
    assert os.listdir(tmp_path) == []
    assert why_unwritable(tmp_path / "nowhere") == "No such file or directory"


def test_a_file_in_place_of_the_folder_is_one_line(old):
    with pytest.raises(FrictionloopError, match="cannot be written"), replacing(old / "new.txt") as beside:
        beside.write_text("new")
    only(old, "old")


def test_nothing_written_is_a_failure(old):
    with pytest.raises(FrictionloopError), replacing(old):
        pass
    only(old, "old")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names on this system")
def test_a_device_or_a_pipe_is_not_replaced(tmp_path):
    """A rename would put a file where root's /dev/null was."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    said = r"pipe: cannot be written \(it is a device or a pipe, not a file\)$"
    with pytest.raises(FrictionloopError, match=said), replacing(pipe) as beside:
        beside.write_text("new")
    assert pipe.is_fifo() and os.listdir(tmp_path) == ["pipe"]
