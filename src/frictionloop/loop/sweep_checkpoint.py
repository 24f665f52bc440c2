"""What a sweep has so far, the file that keeps it, and when it is saved."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.loop.metrics import METRICS
from frictionloop.loop.record import HDF5, load, save
from frictionloop.loop.sweep_points import Points
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.code_version import code_version
from frictionloop.quantities.file_integrity import is_sealed
from frictionloop.quantities.protocol_schema import firmware_folder

SAVE_EVERY_S = 5.0
"""Time between two savings of what is done; a tile may last as long before the next one, 10 s in all (assumed)."""
CLOCK = time.monotonic  # noqa: TID251
"""It decides when a file is saved, never a number."""
COMPUTING = (
    *("quantities", "findings", "parameters", "physics", "sensing", "control"),
    *("perception", "recordings", "rendering", "loop", "firmware"),
)
"""Folders whose code decides the numbers of a run, with the C core beside them."""


def computing(*more: str) -> str:
    """Return a digest of the code that computes a run, and of more folders of this package."""
    return code_version(*COMPUTING, str(firmware_folder()), *more)


RUNS_DONE = "runs_done"
"""Attribute of a sweep that says how many of its runs are done: some have no value."""


class Timely:
    """Saves when it is called and the last saving is some time ago."""

    def __init__(self, save: Callable[[], None], clock: Callable[[], float]) -> None:
        self._save, self._clock, self._last = save, clock, clock()

    def __call__(self) -> None:
        """Save, or not yet."""
        if self._clock() - self._last >= SAVE_EVERY_S:
            self._save()
            self._last = self._clock()


def resumed(
    path: str | os.PathLike[str] | None, key: str, code: str, names: tuple[str, ...], shape: tuple[int, ...]
) -> np.ndarray:
    """Return the values already done in a file, NaN for the rest."""
    if path is None:
        raise FrictionloopError("resume: needs a path")
    if not Path(path).exists():
        return np.full((len(names), math.prod(shape)), np.nan)
    kept = load(path)
    if kept.attrs.get("fingerprint") != key:
        raise FrictionloopError(f"{path}: holds another sweep")
    if kept.attrs.get("code") != code:
        raise FrictionloopError(f"{path}: is of other code, frictionloop {kept.attrs.get('version')}; start over")
    for name in names:
        if name not in kept or kept[name].shape != shape or kept[name].dtype.kind != "f":
            raise FrictionloopError(f"{path}: is damaged (metric {name})")
    return np.array([kept[name].values.ravel() for name in names])


def runs_done(result: xr.Dataset) -> int:
    """Return how many runs of a sweep are done; of a part of one those with a value."""
    if RUNS_DONE in result.attrs:
        return min(int(result.attrs[RUNS_DONE]), int(np.prod(list(result.sizes.values()))))
    numbers = [values.values for values in result.data_vars.values() if values.dtype.kind == "f"]
    return int(np.any(~np.isnan(numbers), axis=0).sum()) if numbers else 0


def check_free(path: str | os.PathLike[str] | None, key: str) -> None:
    """Refuse to start over in a file that keeps anything but the same sweep, finished."""
    if path is None or not Path(path).is_file() or not Path(path).stat().st_size:
        return
    there = load(path) if is_sealed(path) else None
    if there is None or there.attrs.get("fingerprint") != key:
        raise FrictionloopError(f"{path}: holds something else; --force")
    if runs_done(there) < np.prod(list(there.sizes.values())):
        raise FrictionloopError(f"{path}: unfinished; --resume or resume=True")


class Result:
    """The growing result of a sweep and the file that keeps it."""

    def __init__(
        self, values: np.ndarray, names: tuple[str, ...], grid: Points, attrs: dict[str, Any], path: Any
    ) -> None:
        if path is not None and Path(path).suffix.lower() not in HDF5:
            raise FrictionloopError(f"path = {str(path)!r}: must end in {' or '.join(HDF5)}")
        self.values, self.names, self.grid, self.attrs, self.path = values, names, grid, attrs, path
        self.done = int(np.sum(~np.isnan(values).all(axis=0)))

    def dataset(self) -> xr.Dataset:
        """Return the metrics over the sweep's axes, NaN where nothing has run."""
        data = self.variables((*self.grid.axes, "seed"), self.grid.shape)
        return xr.Dataset(data, self.grid.coordinates(), self.attrs | {RUNS_DONE: self.done})

    def variables(self, dims: tuple[str, ...], shape: tuple[int, ...]) -> dict[str, xr.Variable]:
        """Return the metrics over dimensions."""
        about = {name: {"units": METRICS[name].units, "long_name": METRICS[name].long_name} for name in self.names}
        rows = zip(self.names, self.values, strict=True)
        return {name: xr.Variable(dims, row.reshape(shape), about[name]) for name, row in rows}

    def keep(self) -> None:
        """Save what is there, if the sweep has a file."""
        if self.path is not None:
            save(self.dataset(), self.path)
