"""Whether an HDF5 file may be read: it is what was written, reads no other file, and does not outgrow the machine.

The library of HDF5 trusts its files: one wrong byte may keep it busy for ever. A file with no seal of ours is therefore
looked through by another process first, which has a limit of time and memory.
"""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

import h5py

SEALED_BYTES = 2 * 10**9
"""A larger file is not read twice to compare its seal: its chunks have checksums of their own."""
LOOK_S, LOOK_BYTES = 20.0, 4 * 10**9
"""What looking through a file may take (assumed): a recording of a day takes a second."""
MOST_OBJECTS, MOST_ATTRIBUTES, ATTRIBUTE_BYTES = 10_000, 10_000, 10**8
"""More groups, datasets and attributes than any recorder writes (assumed)."""
LARGE_BYTES, EXPANSION = 10**9, 100
"""Above this size in memory, at most so many times that in the file: noise does not compress so well (assumed)."""


def check_hdf5(path: str | os.PathLike[str]) -> None:
    """Refuse a file that is damaged, points to other files or is made to fill the memory."""
    from frictionloop.quantities.units import FrictionloopError

    told = Path(path).stat()
    complaint = _complaint(str(path), told.st_mtime_ns, told.st_size)
    if complaint:
        raise FrictionloopError(f"{path}: {complaint}")


@lru_cache
def _complaint(path: str, _changed: int, size: int) -> str:
    from frictionloop.quantities.file_integrity import is_whole

    whole = is_whole(path) if size <= SEALED_BYTES else None
    if whole is False:
        return "is damaged (another checksum)"
    return looked_through(path) if whole else _looked_through_elsewhere(path)


def _looked_through_elsewhere(path: str) -> str:
    command = [sys.executable, __file__, str(Path(path).absolute())]
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=LOOK_S, check=False)
    except subprocess.TimeoutExpired:
        return f"is damaged (read for {LOOK_S:g} s)"
    if done.returncode:
        said = done.stderr.strip().splitlines()[-1:] or [f"HDF5 ends with code {done.returncode}"]
        return f"cannot be read, empty or damaged ({said[0]:.120})"
    return done.stdout.strip()


def looked_through(path: str) -> str:
    """Return what is wrong with a file, empty if nothing is."""
    with _opened(path) as file:
        found = _walked(file)
    size = os.path.getsize(path)
    return found if isinstance(found, str) else expands(size, found)


def expands(size: int, memory: int) -> str:
    """Return what is wrong with a file of some bytes that takes so many in memory, empty if nothing is."""
    if memory > max(LARGE_BYTES, EXPANSION * size):
        return f"expands to {memory / 1e9:.3g} GB: must be at most {EXPANSION} x its size"
    return ""


def _opened(path: str) -> h5py.File:
    with suppress(OSError):
        return h5py.File(path, "r")
    return h5py.File(path, "r", swmr=True)  # somebody is writing it


def _walked(file: h5py.File) -> str | int:
    """Return what is wrong with what a file holds, or its bytes in memory."""
    groups, met, size, attributes = [file], set(), 0, 0
    while groups:
        group = groups.pop()
        for name in group:
            place = f"{group.name.rstrip('/')}/{name}"
            link = group.get(name, getlink=True)
            if isinstance(link, h5py.ExternalLink):
                return f"{place!r:.80}: must not be in {link.filename!r:.80}"
            if isinstance(link, h5py.SoftLink):
                continue
            item = group[name]
            address = h5py.h5o.get_info(item.id).addr
            if address in met:
                continue
            met.add(address)
            attributes += _attributes(item)
            if len(met) > MOST_OBJECTS or attributes > ATTRIBUTE_BYTES:
                return f"objects > {MOST_OBJECTS}, or attributes > {ATTRIBUTE_BYTES // 10**6} MB"
            if isinstance(item, h5py.Group):
                groups.append(item)
            elif isinstance(item, h5py.Dataset):
                if item.external or item.is_virtual:
                    return f"{place!r:.80}: must not be in another file"
                size += item.nbytes
    return size


def _attributes(item: Any) -> int:
    """Return the bytes that an object's attributes take; each is read, if it is not too large."""
    names = list(item.attrs)[: MOST_ATTRIBUTES + 1]
    size = sum(item.attrs.get_id(name).get_storage_size() for name in names)
    if len(names) > MOST_ATTRIBUTES:
        return ATTRIBUTE_BYTES + 1
    if size <= ATTRIBUTE_BYTES:
        for name in names:
            with suppress(OSError):  # of a kind that h5py does not read
                item.attrs[name]
    return size


if __name__ == "__main__":
    if sys.platform != "win32":  # which has no such limit
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (LOOK_BYTES, LOOK_BYTES))
    print(looked_through(sys.argv[1]))
