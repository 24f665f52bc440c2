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
    with pytest.raises(FrictionloopError, match=f"^{pipe}: .*pipe$"), replacing(pipe) as beside:
        beside.write_text("new")
    assert pipe.is_fifo() and os.listdir(tmp_path) == ["pipe"]


def test_a_link_is_not_followed_and_said(old):
    link = old.with_name("link.txt")
    link.symlink_to(old)
    with pytest.raises(FrictionloopError, match=f"^{link}: .* {old}; "), replacing(link) as beside:
        beside.write_text("new")
    assert link.is_symlink() and old.read_text() == "old"


def test_what_lies_in_the_way_is_neither_followed_nor_replaced(old, monkeypatch):
    """Somebody who guessed the name of the part would have it written where his link leads."""
    monkeypatch.setattr("secrets.token_hex", lambda count: "guessed")
    trap = old.with_name(".new.txt.guessed.part")
    trap.symlink_to(old)
    with pytest.raises(FrictionloopError, match="File exists"), replacing(old.with_name("new.txt")) as beside:
        beside.write_text("new")
    assert old.read_text() == "old" and trap.is_symlink()


def test_two_parts_have_two_names(old):
    with replacing(old) as one, replacing(old) as other:
        assert one != other
        one.write_text("1")
        other.write_text("2")
    only(old, "1")


def test_it_is_on_the_disk_before_it_has_its_name(old, monkeypatch):
    synced, fsync = [], os.fsync

    def noted(handle):
        synced.append((os.fstat(handle).st_ino, old.read_text()))
        fsync(handle)

    monkeypatch.setattr(os, "fsync", noted)
    with replacing(old) as beside:
        beside.write_text("new")
    assert synced[0] == (old.stat().st_ino, "old")


@pytest.mark.skipif(os.name != "posix", reason="rights as POSIX has them")
def test_rights_stay_and_new_files_have_the_usual_ones(old):
    old.chmod(0o640)
    new = old.with_name("new.txt")
    usual = old.with_name("usual.txt")
    usual.touch()
    for path in (old, new):
        with replacing(path) as beside:
            beside.write_text("new")
    assert old.stat().st_mode & 0o777 == 0o640
    assert new.stat().st_mode == usual.stat().st_mode
