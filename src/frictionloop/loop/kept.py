"""What a sweep has so far, and the file that keeps it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.loop.formulas import METRICS
from frictionloop.loop.points import Points
from frictionloop.loop.record import HDF5, load, save
from frictionloop.quantities import FrictionloopError


def resumed(path: str | os.PathLike[str] | None, key: str, names: tuple[str, ...], grid: Points) -> np.ndarray:
    """Return the values already done in a file, NaN for the rest."""
    if path is None:
        raise FrictionloopError("resume: needs the path of the file to continue")
    if not Path(path).exists():
        return np.full((len(names), int(np.prod(grid.shape))), np.nan)
    kept = load(path)
    if kept.attrs.get("fingerprint") != key:
        raise FrictionloopError(
            f"{path}: holds another sweep (system, points, seeds, times, metrics or version differ); choose another"
        )
    return np.array([kept[name].values.ravel() for name in names])


class Result:
    """The growing result of a sweep and the file that keeps it."""

    def __init__(
        self, values: np.ndarray, names: tuple[str, ...], grid: Points, attrs: dict[str, Any], path: Any
    ) -> None:
        if path is not None and Path(path).suffix.lower() not in HDF5:
            raise FrictionloopError(f"path = {str(path)!r}: must end in {' or '.join(HDF5)}, to be resumed")
        self.values, self.names, self.grid, self.attrs, self.path = values, names, grid, attrs, path

    def dataset(self) -> xr.Dataset:
        """Return the metrics over the sweep's axes, NaN where nothing has run."""
        dims = (*self.grid.axes, "seed")
        data = {
            name: xr.Variable(
                dims, row.reshape(self.grid.shape), {"units": METRICS[name].units, "long_name": METRICS[name].long_name}
            )
            for name, row in zip(self.names, self.values, strict=True)
        }
        return xr.Dataset(data, self.grid.coordinates(), self.attrs)

    def keep(self) -> None:
        """Save what is there, if the sweep has a file."""
        if self.path is not None:
            save(self.dataset(), self.path)
