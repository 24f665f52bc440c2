"""A run file that grows while the run is recorded, and can be read after any end of the process that writes it.

HDF5 in its mode for one writer and many readers (SWMR): whatever kills the process, each append that was finished is
there, with a checksum per chunk. No number of rows is held in memory.
"""

from __future__ import annotations

import errno
import os
import secrets
import shutil
import tempfile
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, NamedTuple

import h5netcdf
import h5py
import numpy as np
import xarray as xr

from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.file_integrity import append_seal
from frictionloop.quantities.whole_files import check_target, hold, is_held, sync
from frictionloop.recordings.hdf5_checks import SEALED_BYTES, check_hdf5

CHUNK_ROWS = 5000
"""Rows that are compressed and checked together: a second at 5 kHz."""
BALLAST_BYTES = 1 << 20
"""Room kept on the disk for what HDF5 still has to write when the disk is full: more than a second of all channels."""
ROWS = "rows"
"""Scalar that holds the finished rows while the file grows; it and other counts are attributes afterwards."""
PACKED: dict[str, Any] = {
    "compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True,
    "chunks": (CHUNK_ROWS,), "maxshape": (None,),
}  # fmt: skip


class Column(NamedTuple):
    """One variable over ``time``."""

    dtype: str
    """``"f8"``, or ``"bool"``, which travels as a byte."""
    attrs: Mapping[str, Any]
    """``units`` and ``long_name``."""


class DiskFull(FrictionloopError):
    """The disk takes no more; what was appended is kept."""


def is_taken(path: Path) -> bool:
    """Return whether a file is there that holds something."""
    return path.is_file() and path.stat().st_size > 0


class Spool:
    """The growing file, beside the path that it takes when it is finished.

    Parameters
    ----------
    path : path
        Where the finished file goes.
    columns : mapping of str to Column
        The variables; ``time`` (s) is made from ``spacing_s``.
    spacing_s : float
        Time between rows, in s.
    attrs : mapping
        Attributes that are known at the beginning.
    counts : sequence of str
        Names of the whole numbers that each append brings up to date.

    Raises
    ------
    FrictionloopError
        For a folder in which no file can be made, or a path that is a link.
    """

    def __init__(
        self, path: str | os.PathLike[str], columns: Mapping[str, Column], spacing_s: float, attrs: Mapping[str, Any],
        counts: tuple[str, ...] = (),
    ) -> None:  # fmt: skip
        self.path, self.columns, self.spacing_s, self.rows, self.is_full = Path(path), columns, spacing_s, 0, False
        # A name that nobody can guess, made and never followed: what else lies there is left alone.
        self.partial = self.path.with_name(f"{self.path.stem}.partial-{secrets.token_hex(4)}.h5")
        check_target(self.path)
        try:
            self._ballast = _ballast(self.path.absolute().parent)
            try:
                self._file = h5py.File(self.partial, "x", libver="v110")
            except OSError:
                self._ballast.close()
                raise
        except OSError as error:
            raise FrictionloopError(f"{path}: cannot be written ({error.strerror or error})") from None
        self._prepare(attrs, counts)
        self._syncs = ThreadPoolExecutor(1)
        self._synced: Future[None] | None = None

    def _prepare(self, attrs: Mapping[str, Any], counts: tuple[str, ...]) -> None:
        time = self._file.create_dataset("time", (0,), "f8", **PACKED)
        time.attrs.update(units="s", long_name="time")
        time.make_scale("time")
        for name, column in self.columns.items():
            is_bool = column.dtype == "bool"
            made = self._file.create_dataset(name, (0,), "i1" if is_bool else column.dtype, **PACKED)
            made.dims[0].attach_scale(time)
            made.attrs.update({**column.attrs, **({"dtype": "bool"} if is_bool else {})})
        for name in (ROWS, *counts):
            self._file.create_dataset(name, data=np.int64(0))
        self._file.attrs.update(attrs)
        self._file.swmr_mode = True  # HDF5's own lock is let go here
        self._held = hold(self.partial)

    def append(self, values: Mapping[str, np.ndarray], counts: Mapping[str, int] | None = None) -> None:
        """Append rows, all columns of one length, and bring the counts up to date.

        Raises
        ------
        DiskFull
            When the disk is full: these rows are kept, unless a quota that no call tells took the room before.
        """
        needed = 2 * sum(column.nbytes for column in values.values()) + BALLAST_BYTES // 8
        self.is_full = shutil.disk_usage(self.partial.parent).free < needed
        if self.is_full:
            self._ballast.close()
        try:
            self._write(values, counts or {})
        except (OSError, RuntimeError):
            self.is_full = True
            self._ballast.close()
            for name in ("time", *self.columns):
                self._file[name].resize(self.rows, axis=0)
        if self.is_full:
            raise DiskFull(f"{self.path}: the disk is full")

    def _write(self, values: Mapping[str, np.ndarray], counts: Mapping[str, int]) -> None:
        rows = self.rows + len(next(iter(values.values())))
        columns = {"time": np.arange(self.rows, rows) * self.spacing_s, **values}
        for name, column in columns.items():
            dataset = self._file[name]
            dataset.resize(rows, axis=0)
            dataset[self.rows :] = column
            dataset.flush()
        # The count of rows comes last: what it names is there in all columns.
        for name, count in {**counts, ROWS: rows}.items():
            self._file[name][()] = count
            self._file[name].flush()
        self.rows = rows
        if self._synced is None or self._synced.done():  # a slow disk must not hold up whoever records
            self._synced = self._syncs.submit(os.fsync, self._file.id.get_vfd_handle())

    def finish(self, attrs: Mapping[str, Any]) -> Path:
        """Close the file with the attributes known at the end, and give it its name.

        Raises
        ------
        FrictionloopError
            When that fails, naming the file that holds the rows.
        """
        self._let_go()
        try:
            self._file.close()
            with h5py.File(self.partial, "r+", libver="v110") as file:
                for name in scalars(file):
                    del file[name]
                file.attrs.update(attrs)
            check_target(self.path)
            if self.partial.stat().st_size <= SEALED_BYTES:
                append_seal(self.partial)
            sync(self.partial)
            if self.path != self.partial and is_taken(self.path):  # another process was faster
                raise FileExistsError(errno.EEXIST, "exists", str(self.path))
            self.partial.replace(self.path)
            sync(self.path.absolute().parent)
        except (OSError, RuntimeError) as error:
            raise FrictionloopError(
                f"{self.path}: cannot be written ({_cause(error)}); the {self.rows} rows are in {self.partial}"
            ) from None
        return self.path

    def drop(self) -> None:
        """Close the file and delete it."""
        self._let_go()
        self._file.close()
        self.partial.unlink()

    def _let_go(self) -> None:
        self._ballast.close()
        self._syncs.shutdown()
        if self._held is not None:
            os.close(self._held)
            self._held = None


def _ballast(folder: Path) -> IO[bytes]:
    """Return an open file without a name that keeps room on the disk; it is closed where there is none."""
    file = tempfile.TemporaryFile(dir=folder, buffering=0)  # noqa: SIM115
    try:
        if file.write(bytes(BALLAST_BYTES)) < BALLAST_BYTES:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    except OSError:
        file.close()
        raise
    return file


def scalars(file: h5py.File) -> list[str]:
    """Return the names of the counts of a growing file."""
    return [name for name, dataset in file.items() if isinstance(dataset, h5py.Dataset) and dataset.shape == ()]


def _cause(error: Exception) -> str:
    """Return the system's word of an error of HDF5, whose own text is about its insides."""
    number = getattr(error, "errno", None)
    if number is None:
        _, found, rest = str(error).partition("errno = ")
        number = int(rest.split(",")[0]) if found else None
    return os.strerror(number) if number else str(error).splitlines()[0]


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
        columns = {name: Column(str(file[name].dtype.str[1:]), _attributes(file[name])) for name in names}
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


def _attributes(dataset: h5py.Dataset) -> dict[str, Any]:
    """Return the attributes that are the variable's own, not those of HDF5's dimensions."""
    return {name: dataset.attrs[name] for name in ("units", "long_name", "dtype") if name in dataset.attrs}
