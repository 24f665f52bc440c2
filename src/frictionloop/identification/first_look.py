"""A first look at a file, in seconds whatever its size: the range of each channel in short windows all along it."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionloop.recordings.contents import Channel, Contents
from frictionloop.recordings.stored import LARGE_BYTES
from frictionloop.recordings.tables import read_table
from frictionloop.recordings.whole import READERS, read_contents

WINDOWS, ROWS = 200, 512
"""Windows that are looked at, and rows of each."""
HEAD_BYTES = 2**22
"""Bytes of a large text file that are looked at, since its rows can be found only by reading all before."""


class Trace(NamedTuple):
    """A channel in windows; arrays of one shape."""

    name: str
    unit: str
    row: NDArray[np.float64]
    """Middle of each window."""
    low: NDArray[np.float64]
    high: NDArray[np.float64]


class FirstLook(NamedTuple):
    """What is seen of a file at once."""

    path: str
    traces: tuple[Trace, ...]
    said: str
    """How much of the file was looked at."""


def first_look(path: str | os.PathLike[str]) -> FirstLook:
    """Return the range of each channel in windows all along a file; of a large text file, of its beginning.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read.
    """
    file = Path(path)
    if file.is_file() and READERS.get(file.suffix.lower()) is read_table and file.stat().st_size > LARGE_BYTES:
        contents, said = _head(file), f"the first {HEAD_BYTES >> 20} MB of {file.stat().st_size / 1e6:.0f}"
    else:
        contents, said = read_contents(file), f"{WINDOWS} windows of {ROWS} samples, all along the file"
    return FirstLook(str(path), tuple(_trace(line) for line in contents.signals()), said)


def _head(file: Path) -> Contents:
    with tempfile.TemporaryDirectory() as folder:
        head = Path(folder) / file.name
        with open(file, "rb") as stream:
            head.write_bytes(stream.read(HEAD_BYTES).rpartition(b"\n")[0])
        return read_contents(head)


def _trace(line: Channel) -> Trace:
    size = line.samples.size
    width = min(max(size // WINDOWS, 1), ROWS) if size > WINDOWS * ROWS else max(size // WINDOWS, 1)
    starts = np.unique(np.linspace(0, max(size - width, 0), WINDOWS).astype(int))
    ends = np.array([_ends(line.samples[start : start + width]) for start in starts.tolist()])
    return Trace(line.name, line.unit or "", starts + width / 2, ends[:, 0], ends[:, 1])


def _ends(window: NDArray[Any]) -> tuple[float, float]:
    real = np.abs(window) if window.dtype.kind == "c" else np.asarray(window, dtype=float)
    fine = real[np.isfinite(real)]
    return (float(fine.min()), float(fine.max())) if fine.size else (np.nan, np.nan)
