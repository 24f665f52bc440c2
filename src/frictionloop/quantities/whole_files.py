"""Small files that a person named, looked at before they are read; and files written as a whole or not at all."""

from __future__ import annotations

import errno
import json
import os
import secrets
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from frictionloop.quantities.units import FrictionloopError, must_be

LARGEST_BYTES = 10**6
"""Of a parameter file; all keys of all blocks, and arrays of thousands of samples, fit (assumed)."""


def text_of(path: str | os.PathLike[str], most_bytes: int = LARGEST_BYTES) -> str:
    """Return the text of a file in UTF-8, without a byte-order mark.

    Raises
    ------
    FrictionloopError
        For a path that leads to no file or cannot be read, a file that is larger, or no UTF-8.
    """
    try:
        about = Path(path).stat()
        if not stat.S_ISREG(about.st_mode) and not stat.S_ISDIR(about.st_mode):
            raise FrictionloopError(f"{path}: is no file")
        if about.st_size > most_bytes:
            raise FrictionloopError(f"{path}: has more than {most_bytes:,} bytes")
        return Path(path).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise FrictionloopError(f"{path}: cannot be read ({error.strerror or error})") from None
    except UnicodeDecodeError as error:
        raise FrictionloopError(f"{path}: is no UTF-8 (byte {error.start})") from None


def json_of(path: str | os.PathLike[str], most_bytes: int = 100 * LARGEST_BYTES) -> Any:
    """Return what a JSON file holds.

    Raises
    ------
    FrictionloopError
        As `text_of`, and for what is no JSON.
    """
    try:
        return json.loads(text_of(path, most_bytes))
    except (ValueError, RecursionError) as error:  # a number of thousands of digits too
        if isinstance(error, FrictionloopError):
            raise
        raise FrictionloopError(f"{path}: is not JSON ({error})") from None


if sys.platform == "win32":
    fcntl = None
else:
    import fcntl


TAKEN = (errno.EWOULDBLOCK, errno.EACCES)
"""What a lock says that another process has."""


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a path beside ``path`` to write to; on success it takes the old file's place, on failure it goes.

    Its name cannot be guessed, and nothing that lies there is followed. It is on the disk before it is renamed.

    Raises
    ------
    FrictionloopError
        For a path that cannot be written, or that is a link, a device, a pipe or a socket.
    """
    target = Path(path)
    check_target(target)
    named = target.with_name(f".{target.name}.{secrets.token_hex(8)}.part")
    beside = None
    try:
        os.close(os.open(named, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        beside = named
        yield beside
        # It was there from the beginning: whoever writes nothing must not replace the old file by it.
        if not beside.stat().st_size:
            raise FrictionloopError(f"{target}: cannot be written (nothing came)")
        sync(beside)
        if target.is_file():
            beside.chmod(stat.S_IMODE(target.stat().st_mode))
        beside.replace(target)
        sync(target.parent)
    except OSError as error:
        kept = "; the old file is untouched" if os.path.isfile(target) else ""
        raise FrictionloopError(f"{target}: cannot be written ({error.strerror or error}){kept}") from None
    finally:
        if beside is not None:
            with suppress(OSError):
                beside.unlink()


def check_target(path: Path) -> None:
    """Refuse a file that must not be replaced: a rename puts a file where a link or root's /dev/null was."""
    if not path.name:
        raise must_be("path", str(path), "the name of a file")
    if path.is_symlink() and not _leads_to_device(path):
        raise FrictionloopError(f"{path}: is a link to {os.path.realpath(path)}; name that file")
    if _leads_to_device(path):
        raise FrictionloopError(f"{path}: is a device or a pipe")


def _leads_to_device(path: Path) -> bool:
    return path.exists() and not (path.is_file() or path.is_dir())


def sync(path: Path) -> None:
    """Have what was written on the disk; of a folder also its names, where the system can."""
    with suppress(PermissionError, IsADirectoryError):  # Windows opens no folder
        handle = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def why_unwritable(folder: str | os.PathLike[str]) -> str:
    """Return why no file can be made in a folder, empty if one can; nothing is left there."""
    try:
        with tempfile.TemporaryFile(dir=folder):
            return ""
    except OSError as error:
        return error.strerror or str(error)


def hold(path: Path) -> int | None:
    """Lock a file for as long as this process lives, and return what `os.close` lets go; None where that is unknown.

    The system lets go of it by itself however the process ends, and others may read the file all the same.
    """
    if fcntl is None:
        return None
    descriptor = os.open(path, os.O_RDONLY)
    with suppress(OSError):  # a file system without locks
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    return descriptor


def alone(path: Path) -> int | None:
    """Lock a file, made if need be, against all other processes; `os.close` lets go. None: another has it."""
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        if fcntl is not None:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        else:
            import msvcrt

            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined,unused-ignore]
    except OSError as error:
        if fcntl is None or error.errno in TAKEN:
            os.close(descriptor)
            return None  # else the file system has no locks
    return descriptor


@contextmanager
def only_writer(path: str | os.PathLike[str] | None) -> Iterator[None]:
    """Keep a file from other writers by a lock beside it, which goes at the end; nothing without a file.

    Raises
    ------
    FrictionloopError
        While another process, or thread, writes the file, or where its folder cannot be written to.
    """
    if path is None:
        yield
        return
    lock = lock_of(Path(path))
    try:
        while (handle := alone(lock)) is not None and not _is_there(handle, lock):
            os.close(handle)  # its last owner took it away meanwhile
    except OSError as error:
        raise FrictionloopError(f"{path}: cannot be written ({error.strerror or error})") from None
    if handle is None:
        raise FrictionloopError(f"{path}: is written by another process")
    try:
        yield
    finally:
        with suppress(OSError):  # Windows removes nothing that is open
            lock.unlink()
        os.close(handle)


def lock_of(path: Path) -> Path:
    """Return the lock beside a file that `only_writer` holds."""
    return path.with_name(f".{path.name}.lock")


def _is_there(handle: int, path: Path) -> bool:
    with suppress(FileNotFoundError):
        return os.path.samestat(os.fstat(handle), path.stat())
    return False


def is_held(path: Path) -> bool:
    """Return whether a process that lives holds a file, or reads it as HDF5."""
    if fcntl is None:
        return False
    descriptor = os.open(path, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno in TAKEN
    finally:
        os.close(descriptor)
    return False
