"""A run as an xarray Dataset with units, saved as HDF5 with everything needed to repeat it."""

from __future__ import annotations

import json
import math
import os
import sys
import warnings
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionloop.parameters import SCHEMA, System
from frictionloop.parameters.toml_reader import check_schema
from frictionloop.quantities import FrictionloopError, replacing
from frictionloop.quantities.code_version import package_version
from frictionloop.quantities.file_integrity import is_sealed, seal_of

if TYPE_CHECKING:
    import xarray as xr

HDF5 = (".h5", ".hdf5", ".nc")
VARIABLES: dict[str, tuple[str, str]] = {
    "f_r": ("N", "set-point force"),
    "f_a": ("N", "friction force on the finger"),
    "f_m": ("N", "measured force"),
    "u": ("N", "force command after its clamp"),
    "a": ("um", "vibration amplitude, zero-to-peak"),
    "d": ("N", "disturbance"),
    "saturated": ("1", "command was clamped"),
    "position": ("m", "position along the stroke"),
    "speed": ("m/s", "speed of the finger"),
    "load": ("N", "normal force"),
    "limit": ("N", "friction limit without vibration"),
    "floor": ("N", "friction at the largest amplitude"),
    "sliding": ("1", "sensors see a sliding finger"),
    "scored": ("1", "metrics count this period"),
    "f_r_intended": ("N", "effect at the true place"),
}
AT_ONCE_BYTES = 10**8
"""A run of more is read piece by piece, so that memory does not grow with it (assumed: four minutes of a bench)."""
_FLAGS = ("saturated", "sliding", "scored")


def provenance(system: System, **more: Any) -> dict[str, Any]:
    """Return the attributes that let a result be repeated: System, version, schema and what the caller adds."""
    return {
        "system": system.model_dump_json(),
        "version": package_version(),
        "schema": SCHEMA,
        "source": "simulated",
        **more,
    }


def to_dataset(traces: np.ndarray, system: System, seed: int) -> xr.Dataset:
    """Return the Dataset of one run from its traces, shape (variables, periods), row k holding the values at t_k."""
    import pandas as pd  # type: ignore[import-untyped]
    import xarray as xr  # only here and below: a live page, which runs the loop too, is open half a second sooner

    # An index, and the fast path: by the other ones xarray loads dask, where that is installed.
    time = np.arange(traces.shape[1]) / system.controller.rate_hz
    if system.motion.kind == "sliding":  # without place, speed and load, whichever loop ran it
        traces = traces[: list(VARIABLES).index("position")]
    data = {
        name: xr.Variable("time", row != 0 if name in _FLAGS else row, described(name), fastpath=True)
        for row, name in zip(traces, VARIABLES, strict=False)
    }
    coordinate = {"time": xr.Variable("time", pd.Index(time), {"units": "s", "long_name": "time"})}
    return xr.Dataset(data, coordinate, provenance(system, seed=seed))


def described(name: str) -> dict[str, str]:
    """Return the attributes of a variable."""
    return dict(zip(("units", "long_name"), VARIABLES[name], strict=True))


def system_of(run: xr.Dataset) -> System:
    """Return the System that a run carries.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate``, ``sweep`` or ``load``.

    Raises
    ------
    FrictionloopError
        For a Dataset without a System, or with one that this version does not accept.
    """
    try:
        tree = json.loads(run.attrs["system"])
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError):
        raise FrictionloopError("Dataset carries no System (attribute 'system')") from None
    return System.from_tree(tree, "run: ")


def save(run: xr.Dataset, path: str | os.PathLike[str]) -> None:
    """Save a run or sweep as HDF5 (netCDF-4 layout) or as a CSV table; the old file stays whole until then.

    A table has one row per control period, or per run of a sweep, and the units in its header. It has no System: only
    HDF5 can be loaded again.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate`` or ``sweep``.
    path : path
        File to write: .h5, .hdf5 or .nc, or .csv. One that this package wrote is replaced, and any .csv.

    Raises
    ------
    FrictionloopError
        For another ending, a file that cannot be written, or one of others.
    """
    if (ending := Path(path).suffix.lower()) not in (*HDF5, ".csv") and str(path):
        raise FrictionloopError(f"{str(path)!r}: must end in {', '.join(HDF5)} or .csv")
    if ending == ".csv":
        named = {str(name): _header(str(name), values) for name, values in run.variables.items()}
        table = run.to_dataframe(dim_order=[*map(str, run.dims)]).reset_index().rename(columns=named)
        with replacing(path) as beside:
            table.to_csv(beside, index=False)
        return
    if os.path.isfile(path) and os.path.getsize(path) and not is_sealed(path):
        raise FrictionloopError(f"{path}: was not written by frictionloop; name another")
    encoding = {name: {"zlib": True, "complevel": 1, "shuffle": True} for name in run.data_vars if run[name].ndim}
    # HDF5 writes to memory: when a disk is full, its own writing leaves handles that crash the interpreter at exit.
    with _without_cluster():
        content = bytes(run.to_netcdf(engine="h5netcdf", encoding=encoding))
    with replacing(path) as beside:
        beside.write_bytes(content + seal_of(content))


def _without_cluster() -> Any:
    """Keep xarray from asking a Dask cluster for a lock on memory that is ours alone; the cluster knows none."""
    dask = sys.modules.get("dask")
    return dask.config.set(scheduler="synchronous") if dask else nullcontext()


def _header(name: str, values: xr.Variable) -> str:
    unit = values.attrs.get("units", "1")
    return name if unit == "1" else f"{name} [{unit}]"


def load(path: str | os.PathLike[str], *, from_s: float | None = None, until_s: float | None = None) -> xr.Dataset:
    """Load a run or sweep that ``save`` wrote or a device recorded.

    A recording whose process was killed loads too, up to its last second, with a warning and the attribute
    ``unfinished``.

    Parameters
    ----------
    path : path
        The file.
    from_s, until_s : float, optional
        Part of a run to load, in s, both included; all of it by default. What has more than 100 MB is not read at once:
        the Dataset then reads from the file what is asked of it by ``isel``, and has no index of time.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, is no run file, is not what was saved, reads other files, expands out of
        measure, or was written by a newer version.
    """
    import xarray as xr

    from frictionloop.loop.growing_file import unfinished
    from frictionloop.recordings.hdf5_checks import check_hdf5

    try:
        check_hdf5(path)
        if (run := unfinished(path)) is not None:
            warnings.warn(f"{path}: unfinished, {run.sizes['time']} samples", stacklevel=2)
            run = run.assign_attrs(unfinished=1)
        else:
            run = xr.open_dataset(path, engine="h5netcdf", create_default_indexes=False)
        if from_s is not None or until_s is not None:
            run = _part(run, from_s, until_s)
        if run.nbytes <= AT_ONCE_BYTES:
            run = run.load()
            run.close()
            for name in run.dims:
                run = run.set_xindex(str(name)) if name in run.coords else run
    except FileNotFoundError:
        raise FrictionloopError(f"{path}: cannot be read (no such file{_partial(Path(path))})") from None
    except FrictionloopError:
        raise
    except Exception as error:  # h5py and h5netcdf raise many kinds for a damaged file
        raise FrictionloopError(
            f"{path}: cannot be read as a run file ({type(error).__name__}: {str(error).splitlines()[0]})"
        ) from None
    if "schema" not in run.attrs:
        raise FrictionloopError(f"{path}: is no run file (attribute 'schema')")
    schema = run.attrs["schema"]
    check_schema(int(schema) if isinstance(schema, np.integer) else schema, f"{path}: ")
    for name in run.data_vars:
        if run[name].dtype == np.int8:  # booleans travel as bytes
            run[name] = run[name].astype(bool)
    return run


def _part(run: xr.Dataset, from_s: float | None, until_s: float | None) -> xr.Dataset:
    """Return the rows from one time to another; rows are evenly spaced."""
    spacing_s = float(run["time"][1]) if run.sizes["time"] > 1 else 1.0
    first = 0 if from_s is None else math.ceil(from_s / spacing_s - 1e-6)
    stop = None if until_s is None else max(math.floor(until_s / spacing_s + 1e-6) + 1, 0)
    return run.isel(time=slice(max(first, 0), stop))


def _partial(path: Path) -> str:
    """Return a hint at what an unfinished recording for this path left."""
    found = sorted(path.parent.glob(f"{path.stem}.partial-*.h5"))
    return f"; unfinished: {found[-1]}" if found else ""
