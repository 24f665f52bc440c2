"""Arrays in binary files as channels: HDF5, NetCDF 3 and 4, MAT 5 and 7.3, NumPy's."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from frictionloop.findings import Finding
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.units import known_unit
from frictionloop.recordings.contents import (
    MOST_LINES,
    Channel,
    Contents,
    Stored,
    is_large,
    left_out,
    lines_of,
    told_rates,
)
from frictionloop.recordings.hdf5_checks import check_hdf5, expands
from frictionloop.recordings.text_numbers import header, iso_date, plain_text, told_date

_CREATED = re.compile(rb"Created on: (\w{3} \w{3} [\d :]{8,16})")
"""Where the header of a MAT file says its date."""
ONLY = "array"
"""What the one array of a NPY file is called."""
KEPT = 2
"""Blocks of all lines that are kept, for the next line is usually asked for the same rows."""
Attributes = Mapping[str, Mapping[str, Any]]


def numpy_contents(path: Path) -> Contents:
    """Return the arrays of a NPZ or NPY file; Python objects are left out, since reading one may run anything."""
    found: list[Finding] = []
    if path.suffix.lower() == ".npy":
        return _of_arrays({ONLY: np.load(path, allow_pickle=False)})
    arrays: dict[str, NDArray[Any]] = {}
    with ZipFile(path) as packed:  # what an array says of itself beyond this is an error of NumPy's
        if wrong := expands(path.stat().st_size, sum(each.file_size for each in packed.infolist())):
            raise FrictionloopError(f"{path}: {wrong}")
    with np.load(path, allow_pickle=False) as file:
        for name in file.files:
            try:
                arrays[name] = file[name]
            except ValueError:
                found.append(left_out(name, "a Python object"))
    return _of_arrays(arrays, found)


def hdf5_contents(path: Path) -> Contents:
    """Return the datasets of an HDF5 or NetCDF file, and of a MAT file of version 7.3, which is transposed."""
    import h5py

    with open(path, "rb") as stream:
        if stream.read(3) == b"CDF":
            return _netcdf3_contents(path)
    check_hdf5(str(path))
    arrays: dict[str, NDArray[Any]] = {}
    said: dict[str, dict[str, Any]] = {}
    dropped: list[Finding] = []
    large: list[Channel] = []
    matlab = path.suffix.lower() == ".mat"

    def look(name: str, item: Any) -> None:
        said[name] = dict(item.attrs)
        if not isinstance(item, h5py.Dataset) or name.startswith("#") or is_bare_dimension(item):
            return
        kind = plain_text(said[name].get("MATLAB_class", "")) if matlab else ""
        if kind not in ("", "double", "single", "logical") and "int" not in kind:
            if kind not in ("char", "cell"):
                dropped.append(left_out(name, f"a MATLAB object ({kind})"))
        elif item.dtype.kind in "iufbc" and len(item.shape) <= 2 and is_large(path, item.size, item.dtype.itemsize):
            large.extend(_stored_lines(path, name, item))
        elif item.dtype.kind in "iufbcV" and item.shape is not None:
            values = np.asarray(unpacked(item[()], said[name]))
            arrays[name] = values.T if matlab else values
        elif item.size and item.size > 1:
            dropped.append(left_out(name, "text"))

    with h5py.File(path) as file:
        said[""] = dict(file.attrs)
        file.visititems(look)
    return _of_arrays(arrays, dropped, said, large)


def _netcdf3_contents(path: Path) -> Contents:
    from scipy.io import netcdf_file

    with netcdf_file(path, mmap=False) as file:
        said = {name: dict(each._attributes) for name, each in file.variables.items()}
        said[""] = dict(file._attributes)
        native = {name: each.data.astype(each.data.dtype.newbyteorder("=")) for name, each in file.variables.items()}
    return _of_arrays({name: np.asarray(unpacked(each, said[name])) for name, each in native.items()}, [], said)


def mat_contents(path: Path) -> Contents:
    """Return the arrays of a MAT file, those in structures as structure/field; opaque MATLAB objects are left out.

    SciPy's list of what a file holds (``whosmat``) fails on such objects; reading the whole file does not.
    """
    import h5py
    from scipy.io import loadmat

    with open(path, "rb") as stream:
        created = _CREATED.search(stream.read(128))
    date = iso_date(created[1].decode("ascii", "replace")) if created else ""
    if h5py.is_hdf5(path):
        found = hdf5_contents(path)
        return replace(found, date=found.date or date)
    if wrong := expands(path.stat().st_size, _bytes_in(path)):
        raise FrictionloopError(f"{path}: {wrong}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        tree = loadmat(path, appendmat=False)
    dropped: list[Finding] = []
    arrays = dict(_leaves({name: value for name, value in tree.items() if not str(name).startswith("__")}, dropped))
    found = _of_arrays(arrays, dropped)
    return replace(found, date=found.date or date)


def _bytes_in(path: Path) -> int:
    """Return what the variables take, 0 where SciPy cannot list them, as beside an object of MATLAB's."""
    from scipy.io import whosmat

    try:
        return sum(8 * math.prod(shape) for _, shape, _ in whosmat(path, appendmat=False))
    except Exception:  # an AttributeError as of SciPy 1.17; the whole file is read then
        return 0


def _leaves(tree: Mapping[Any, Any], dropped: list[Finding], prefix: str = "") -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield the arrays of a MAT file by their path; what is an object is dropped."""
    from scipy.io.matlab import MatlabFunction, MatlabOpaque

    for name, value in tree.items():
        full = f"{prefix}{name}"
        if isinstance(value, (MatlabOpaque, MatlabFunction)) or name in (None, "None"):
            dropped.append(left_out("unnamed" if name in (None, "None") else full, "a MATLAB object"))
        elif not isinstance(value, np.ndarray):
            dropped.append(left_out(full, "a sparse matrix: full() makes it one of numbers"))
        elif value.dtype.names:
            for k, each in enumerate(value.flat):
                inside = {field: each[field] for field in value.dtype.names}
                yield from _leaves(inside, dropped, f"{full}/" if value.size == 1 else f"{full}({k + 1})/")
        elif value.dtype.kind == "O":
            for k, each in enumerate(value.flat):
                yield from _leaves({f"{{{k + 1}}}": each}, dropped, full)
        else:
            yield full, value


def _of_arrays(
    arrays: Mapping[str, NDArray[Any]],
    dropped: Sequence[Finding] = (),
    said: Attributes | None = None,
    more: Sequence[Channel] = (),
) -> Contents:
    """Return arrays as channels, each with the rate and the times that stand nearest to it."""
    said = said or {}
    lines = [
        line for name, array in arrays.items() for line in lines_of(name, array, attribute_unit(said.get(name, {})))
    ]
    channels = with_times([*lines, *more])
    scalars = {name: array for name, array in arrays.items() if array.size == 1}
    told: dict[str, list[tuple[str, Any]]] = {folder: list(each.items()) for folder, each in said.items()}
    for name, value in scalars.items():
        folder, _, leaf = name.rpartition("/")
        told.setdefault(folder, []).append((leaf, value))
    rates = {folder: rate for folder, pairs in told.items() if (rate := told_rates(pairs))}
    used = {folder for each in channels for folder in (_array(each.name), *_folders(each.name))}
    settings = {f"{by} of {at!r}": hertz for at, each in rates.items() if at not in used for by, hertz in each.items()}
    timed = (
        each if each.tells_time else replace(each, rates_hz=_nearest(each.name, rates, settings)) for each in channels
    )
    deep = [left_out(name, f"{each.ndim} dimensions") for name, each in arrays.items() if np.squeeze(each).ndim > 2]
    pairs = [(name, value) for each in said.values() for name, value in each.items()]
    return Contents(tuple(timed), (*dropped, *deep), told_date([*pairs, *arrays.items()]))


def _nearest(name: str, rates: Mapping[str, Mapping[str, float]], settings: Mapping[str, float]) -> Mapping[str, float]:
    """Return what tells the rate of an array: its own attributes, those and numbers of its group, of groups above.

    Without any, those of groups of settings, which hold no channels.
    """
    return next((rates[at] for at in (_array(name), *_folders(name)) if at in rates), settings)


def with_times(channels: Sequence[Channel]) -> list[Channel]:
    """Return channels with the nearest times of as many samples: of their group, or of one above it."""
    clocks: dict[tuple[str, int], Channel] = {}
    for each in channels:
        if each.tells_time:
            clocks.setdefault((each.name.rpartition("/")[0], each.samples.size), each)
    found = []
    for each in channels:
        near = (clocks[at, each.samples.size] for at in _folders(each.name) if (at, each.samples.size) in clocks)
        found.append(each if each.tells_time else replace(each, times=next(near, None)))
    return found


def _array(name: str) -> str:
    """Return the array that a line is one of."""
    return re.sub(r"\[[^\[\]]*\]$", "", name)


def _folders(name: str) -> Iterator[str]:
    """Yield the group of a name, and those above it, "" last."""
    folder = name
    while folder:
        folder = folder.rpartition("/")[0]
        yield folder


def _stored_lines(path: Path, name: str, array: Any) -> Iterator[Channel]:
    """Yield the lines of a large dataset of HDF5 along its longer side, read by the block."""
    long = int(np.argmax(array.shape))
    lines = array.size // array.shape[long]
    if lines > MOST_LINES:
        return
    attributes = dict(array.attrs)
    told = unpacked(np.zeros(1, array.dtype), attributes).dtype
    changed = path.stat().st_mtime_ns

    def rows(k: int, first: int, stop: int) -> NDArray[Any]:
        return np.asarray(_hdf5_block(path, changed, name, long, first, stop)[:, k])

    unit = attribute_unit(attributes) or header(name.rpartition("/")[2]).unit
    for k in range(lines):
        shown = name if lines == 1 else f"{name}[:, {k}]"
        yield Channel(shown, Stored(array.shape[long], told, partial(rows, k)), unit)


@lru_cache(KEPT)
def _hdf5_block(path: Path, _changed: int, name: str, long: int, first: int, stop: int) -> NDArray[Any]:
    import h5py

    with h5py.File(path) as file:
        array = file[name]
        block = array[first:stop] if long == 0 else array[:, first:stop].T
        return np.asarray(unpacked(block, dict(array.attrs))).reshape(stop - first, -1)


def is_bare_dimension(array: Any) -> bool:
    """Tell what NetCDF keeps for a dimension without coordinates: zeros under its name."""
    return bytes(array.attrs.get("NAME", b"")).startswith(b"This is a netCDF dimension but not")


def unpacked(stored: NDArray[Any], packing: Mapping[str, Any]) -> NDArray[Any]:
    """Undo the packing of the NetCDF conventions: what is missing becomes NaN."""
    values = stored
    if "_FillValue" in packing:
        values = np.where(stored == packing["_FillValue"], np.nan, stored)
    if "scale_factor" in packing:
        values = values * packing["scale_factor"]
    return values + packing["add_offset"] if "add_offset" in packing else values


UNIT_NAMES = ("units", "unit")
"""Attributes that say the unit, in any case."""


def attribute_unit(attributes: Mapping[str, Any]) -> str | None:
    """Return what an attribute says of the unit, which some programs write as bytes or as a list of one."""
    lower = {name.lower(): value for name, value in attributes.items()}
    said = np.ravel(next((lower[name] for name in UNIT_NAMES if name in lower), ""))
    text = plain_text(said[:1]).partition(" since ")[0]  # NetCDF: nanoseconds since 2024-03-05
    return known_unit(text) or text.strip() or None
