"""Channels of large files, read by the block: HDF5 and MAT 7.3, WAV, TDMS."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionloop.quantities.extra import needed
from frictionloop.recordings.contents import MOST_LINES, Channel
from frictionloop.recordings.headers import header
from frictionloop.recordings.stored import Stored

KEPT = 2
"""Blocks of all lines that are kept, for the next line is usually asked for the same rows."""


def hdf5_lines(path: Path, name: str, array: Any, unit: str | None, undo: Callable[..., Any]) -> Iterator[Channel]:
    """Yield the lines of a dataset of HDF5 along its longer side; ``undo`` takes its packing off."""
    long = int(np.argmax(array.shape))
    lines = array.size // array.shape[long]
    if lines > MOST_LINES:
        return
    told = undo(np.zeros(1, array.dtype), dict(array.attrs)).dtype
    changed = path.stat().st_mtime_ns

    def rows(k: int, first: int, stop: int) -> NDArray[Any]:
        return np.asarray(_hdf5_block(path, changed, name, long, first, stop, undo)[:, k])

    stated = unit or header(name.rpartition("/")[2]).unit
    for k in range(lines):
        shown = name if lines == 1 else f"{name}[:, {k}]"
        yield Channel(shown, Stored(array.shape[long], told, partial(rows, k)), stated)


@lru_cache(KEPT)
def _hdf5_block(
    path: Path, _changed: int, name: str, long: int, first: int, stop: int, undo: Callable[..., Any]
) -> NDArray[Any]:
    import h5py

    with h5py.File(path) as file:
        array = file[name]
        block = array[first:stop] if long == 0 else array[:, first:stop].T
        return np.asarray(undo(block, dict(array.attrs))).reshape(stop - first, -1)


def wav_line(path: Path, whole: Any, k: int, scaled: Callable[[NDArray[Any]], NDArray[Any]]) -> Stored:
    """Return a channel of a WAV file, of which ``whole`` is a map that nobody reads; a map's pages count as memory."""
    width = whole.shape[1]

    def rows(first: int, stop: int) -> NDArray[Any]:
        offset = whole.offset + first * width * whole.dtype.itemsize
        found = np.fromfile(path, whole.dtype, (stop - first) * width, offset=offset)
        return scaled(found.reshape(-1, width)[:, k])

    return Stored(len(whole), scaled(np.zeros(1, whole.dtype)).dtype, rows)


def tdms_line(path: Path, group: str, channel: str, size: int, dtype: Any) -> Stored:
    """Return a channel of a TDMS file."""

    def rows(first: int, stop: int) -> NDArray[Any]:
        with needed("nptdms", "npTDMS (LGPL)", "identify").TdmsFile.open(path) as file:
            return np.asarray(file[group][channel].read_data(first, stop - first))

    return Stored(size, np.dtype(dtype), rows)
