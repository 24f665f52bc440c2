"""A run file that is still growing, or whose process ended without finishing it: reading it, and writing it anew."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np
import xarray as xr

from frictionloop.loop.spool import CHUNK_ROWS, ROWS, Column, Spool, scalars
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.files import is_held
from frictionloop.recordings.hdf5 import check_hdf5


def unfinished(path: str | os.PathLike[str]) -> xr.Dataset | None:
    """Return a growing or cut-off file's rows as a lazy Dataset with its counts as attributes, None for any other file.

    Only rows that all columns have are there.
    """
    counts: dict[str, int] = {}
    with suppress(OSError), h5py.File(path, "r", swmr=True) as file:
        counts = {name: int(file[name][()]) for name in scalars(file)}
    if ROWS not in counts:
        return None
    store = xr.backends.H5NetCDFStore(h5netcdf.File(path, "r", swmr=True))
    opened = xr.open_dataset(store, create_default_indexes=False)
    run = opened.drop_vars(list(counts)).isel(time=slice(0, counts.pop(ROWS)))
    run.set_close(opened.close)
    return run.assign_attrs(counts)


def recovered(path: str | os.PathLike[str], out: str | os.PathLike[str]) -> tuple[int, int]:
    """Write an unfinished file anew as a finished one, and return its rows and how many of them were damaged.

    Rows of a chunk whose checksum does not fit are NaN, and 0 in what is no number.

    Raises
    ------
    FrictionloopError
        For a file that is no unfinished recording, or one that is still recorded, or an ``out`` that cannot be written.
    """
    try:
        check_hdf5(path)
    except FileNotFoundError:
        raise FrictionloopError(f"{path}: cannot be read (no such file)") from None
    if is_held(Path(path)):
        raise FrictionloopError(f"{path}: in use by another process")
    if unfinished(path) is None:
        raise FrictionloopError(f"{path}: is no unfinished recording")
    with h5py.File(path, "r", swmr=True) as file:
        counts = {name: int(file[name][()]) for name in scalars(file)}
        rows = counts.pop(ROWS)
        names = [name for name in file if name not in (ROWS, *counts, "time")]
        columns = {name: Column(str(file[name].dtype.str[1:]), _told(file[name])) for name in names}
        spacing_s = float(file["time"][1]) if rows > 1 else 0.0
        spool, damaged = Spool(out, columns, spacing_s, dict(file.attrs)), 0
        for first in range(0, rows, CHUNK_ROWS):
            chunks = {name: _chunk(file[name], first, min(first + CHUNK_ROWS, rows)) for name in names}
            damaged += max(len(values) * is_bad for values, is_bad in chunks.values())
            spool.append({name: values for name, (values, _) in chunks.items()})
    spool.finish({**counts, "recovered": 1, "damaged_samples": damaged})
    return rows, damaged


def _chunk(dataset: h5py.Dataset, first: int, last: int) -> tuple[np.ndarray, bool]:
    """Return some rows, and whether they could not be read."""
    try:
        return dataset[first:last], False
    except OSError:
        return np.full(last - first, np.nan if dataset.dtype.kind == "f" else 0, dataset.dtype), True


def _told(dataset: h5py.Dataset) -> dict[str, Any]:
    """Return the attributes that are the variable's own, not those of HDF5's dimensions."""
    return {name: dataset.attrs[name] for name in ("units", "long_name", "dtype") if name in dataset.attrs}
