"""A first look at a file, in seconds whatever its size: the range of each channel in short windows all along it."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionloop.recordings.contents import Channel, Contents
from frictionloop.recordings.stored import LARGE_BYTES
from frictionloop.recordings.tables import read_table
from frictionloop.recordings.whole import READERS, read_contents

WINDOWS, ROWS = 100, 512
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
    signals = contents.signals() or contents.channels
    sizes = dict.fromkeys(line.samples.size for line in signals)
    found = [each for size in sizes for each in _traces([line for line in signals if line.samples.size == size])]
    return FirstLook(str(path), tuple(found), said)


def _head(file: Path) -> Contents:
    with tempfile.TemporaryDirectory() as folder:
        head = Path(folder) / file.name
        with open(file, "rb") as stream:
            head.write_bytes(stream.read(HEAD_BYTES).rpartition(b"\n")[0])
        return read_contents(head)


def _traces(lines: Sequence[Channel]) -> tuple[Trace, ...]:
    """Return the windows of channels of one length; window by window, for a file has the channels side by side."""
    size = lines[0].samples.size
    width = max(min(size // WINDOWS, ROWS), 1) if size > WINDOWS * ROWS else max(size // WINDOWS, 1)
    starts = np.unique(np.linspace(0, max(size - width, 0), WINDOWS).astype(int))
    ends = np.array([[_ends(line.samples[k : k + width]) for line in lines] for k in starts.tolist()])
    return tuple(
        Trace(line.name, line.unit or "", starts + width / 2, ends[:, k, 0], ends[:, k, 1])
        for k, line in enumerate(lines)
    )


def _ends(window: NDArray[Any]) -> tuple[float, float]:
    real = np.abs(window) if window.dtype.kind == "c" else np.asarray(window, dtype=float)
    fine = real[np.isfinite(real)]
    return (float(fine.min()), float(fine.max())) if fine.size else (np.nan, np.nan)
