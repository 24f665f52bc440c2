"""Columns of binary files: HDF5 and NetCDF-4, MAT 5 and 7.3, NumPy's, WAV."""

from __future__ import annotations

import math
import os
import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from frictionloop.parameters.sources import Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.column import DEFAULT, Column, column_number, no_column
from frictionloop.recordings.contents import rate_beside, told_rate
from frictionloop.recordings.hdf5 import check_hdf5, expands
from frictionloop.recordings.headers import attribute_unit, header, is_bare_dimension, is_time, unpacked

Array = NDArray[np.float64]
_LINE = re.compile(r"(.*?)\s*(?:\[\s*(?::\s*,\s*(\d+)|(\d+)\s*,\s*:)\s*\])?", re.DOTALL)
ONLY = "array"
"""What the one array of a NPY file is called."""


def read_hdf5(recording: Recording) -> Column:
    """Return a dataset, or a line of one, of an HDF5 or NetCDF-4 file."""
    import h5py

    check_hdf5(recording.path)
    items: dict[str, Any] = {}
    with h5py.File(recording.path) as file:
        file.visititems(lambda name, item: items.update({name: item}))
        datasets = {name: item for name, item in items.items() if isinstance(item, h5py.Dataset)}
        arrays = {name: item for name, item in datasets.items() if not is_bare_dimension(item)}
        column = picked(recording, arrays, in_matlab=recording.path.lower().endswith(".mat"))
        said = {name: item.attrs for name, item in items.items()} | {"": file.attrs}
        return with_rate(recording, column, arrays, said)


def read_mat(recording: Recording) -> Column:
    """Return an array, or a line of one, of a MAT file of version 5 or 7.3."""
    import h5py
    from scipy.io import loadmat

    if h5py.is_hdf5(recording.path):
        return read_hdf5(recording)
    variable = re.split(r"[/\[]", recording.column)[0].strip()
    # The variable asked for and times alone in memory; all of them to find one by number or to list them.
    check_mat(recording.path)
    there = [name for name, _ in _listed(recording.path)]
    known = variable in there and not is_time(variable)
    beside = (name for name in there if is_time(name) or told_rate(name, 1.0) is not None)
    tree = loadmat(recording.path, appendmat=False, variable_names=[variable, *beside] if known else None)
    arrays = dict(_flat(tree))
    return with_rate(recording, picked(recording, arrays), arrays, {})


def with_rate(
    recording: Recording, column: Column, arrays: Mapping[str, Any], said: Mapping[str, Mapping[str, Any]]
) -> Column:
    """Return a column with the sampling rate that the nearest attribute or number beside it tells."""
    found = rate_beside(recording.path, column.path, said, arrays)
    return column if found is None else replace(column, rate_by=found[0], rate_hz=found[1])


def check_mat(path: str) -> None:
    """Refuse a MAT file of version 5 whose variables are made to fill the memory."""
    size = os.path.getsize(path)
    if wrong := expands(size, sum(8 * math.prod(shape) for _, shape in _listed(path))):
        raise FrictionloopError(f"{path}: {wrong}")


def _listed(path: str) -> list[tuple[str, tuple[int, ...]]]:
    """Return the variables' names and shapes; none where SciPy cannot list them, as beside an object of MATLAB's."""
    from scipy.io import whosmat

    try:
        return [(name, shape) for name, shape, _ in whosmat(path, appendmat=False)]
    except Exception:  # an AttributeError as of SciPy 1.17; the whole file is read then
        return []


def _flat(tree: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield the arrays of a MAT file, those inside structures as structure/field."""
    from scipy.io.matlab import MatlabOpaque

    for name, value in tree.items():
        if isinstance(value, MatlabOpaque):
            continue
        if isinstance(value, np.ndarray) and value.dtype.names and value.size == 1:
            yield from _flat({field: value[field].flat[0] for field in value.dtype.names}, f"{prefix}{name}/")
        elif isinstance(value, np.ndarray):
            yield prefix + name, value


def picked(recording: Recording, arrays: Mapping[str, Any], in_matlab: bool = False) -> Column:
    """Return the array, or the line of one, that ``column`` names, and the times beside it."""
    name, samples, lines = _pick(recording, arrays, in_matlab)
    beside = [other for other in arrays if other != name and arrays[other].size == samples.size]
    folder = name.rpartition("/")[0]
    clock = next((other for other in beside if other.rpartition("/")[0] == folder and _is_clock(other)), None)
    beside_it = recording.model_copy(update={"column": clock})
    times = None if clock is None else _column(beside_it, clock, arrays[clock], np.ravel(arrays[clock][()]))
    others = [repr(other) for other in beside if other != clock and arrays[other].dtype.kind in "iuf"]
    return _column(recording, name, arrays[name], samples, times, others + lines)


def _is_signal(name: str, array: Any) -> bool:
    """Tell whether an array may be a force: no times, no rate, no single number."""
    return array.size > 1 and not _is_clock(name) and told_rate(name.rpartition("/")[2], 1.0) is None


def _is_clock(name: str) -> bool:
    return is_time(name.rpartition("/")[2])


def _column(
    recording: Recording,
    name: str,
    array: Any,
    samples: NDArray[Any],
    times: Column | None = None,
    others: Sequence[str] = (),
) -> Column:
    attributes = dict(getattr(array, "attrs", {}))
    leaf = name.rpartition("/")[2]
    unit = attribute_unit(attributes) or header(leaf).unit
    values = unpacked(samples, attributes)
    return Column(values, in_array(recording, samples), leaf, unit, times=times, others=others, path=name)


def _pick(recording: Recording, arrays: Mapping[str, Any], in_matlab: bool) -> tuple[str, NDArray[Any], list[str]]:
    """Return the name of the array, the line of it that is asked for, and what other lines it has.

    MATLAB stores transposed.
    """
    order = -1 if in_matlab else 1
    shapes = {
        name: array.shape[::order]
        for name, array in arrays.items()
        if array.dtype.kind in "iufb" and array.ndim in (1, 2) and not name.startswith("#")
    }
    match = _LINE.fullmatch(recording.column.strip())
    name, column, row = match.groups() if match else (recording.column, None, None)
    name = name.strip("/")
    if name not in shapes and name == Recording.model_fields["column"].default:
        signals = [each for each in shapes if _is_signal(each, arrays[each])]
        if len(signals) > 1:
            raise no_column(recording, list(map(repr, signals)), f"{DEFAULT} may be any of {len(signals)} signals")
        name = signals[0] if signals else name
    if name not in shapes and name.isdecimal() and int(name) < len(shapes):
        name = list(shapes)[int(name)]
    if name not in shapes:
        sizes = [" x ".join(map(str, shape)) for shape in shapes.values()]
        raise no_column(recording, [f"{name!r} ({size})" for name, size in zip(shapes, sizes, strict=True)])
    array, shape = arrays[name], shapes[name]
    if column is None and row is None and (len(shape) == 1 or 1 in shape):
        return name, np.ravel(array[()]), []
    axis, k = (0, int(row)) if row is not None else (1, int(column or 0))
    if len(shape) == 1:
        raise no_column(recording, [repr(name)])
    whole = column is None and row is None
    if whole or k >= shape[axis]:
        why = f"takes the array {name!r}, which has {shape[1]} columns" if whole else "is not there"
        raise no_column(recording, [f"'{name}[:, 0]' to '{name}[:, {shape[1] - 1}]' or a row '{name}[0, :]'"], why)
    lines = [f"'{name}[:, {i}]'" for i in range(shape[1]) if i != k] if axis else []
    return name, array[(slice(None), k)[:: order if axis else -order]], lines


def in_array(recording: Recording, samples: NDArray[Any]) -> Callable[[int], str]:
    """Return how a sample of an array is named."""
    return lambda i: f"column {recording.column!r} at index {i} is {samples[i]}"


def read_npy(recording: Recording) -> Column:
    """Return the array of a NPY file, or a column of it ("array[:, k]")."""
    return picked(recording, {ONLY: np.load(recording.path, allow_pickle=False)})


def read_npz(recording: Recording) -> Column:
    """Return an array, or a line of one, of a NPZ file."""
    with ZipFile(recording.path) as packed:
        size = sum(each.file_size for each in packed.infolist())
    if wrong := expands(os.path.getsize(recording.path), size):
        raise FrictionloopError(f"{recording.path}: {wrong}")
    arrays: dict[str, Any] = {}
    with np.load(recording.path, allow_pickle=False) as file:
        for name in file.files:
            try:
                arrays[name] = file[name]
            except ValueError:  # a Python object
                continue
    return with_rate(recording, picked(recording, arrays), arrays, {})


def read_wav(recording: Recording) -> Column:
    """Return a channel of a WAV file; integers become -1 to 1 (full scale)."""
    from scipy.io import wavfile

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wavfile.WavFileWarning)
        warnings.filterwarnings("error", "Reached EOF", wavfile.WavFileWarning)
        rate_hz, channels = wavfile.read(recording.path)
    channels = channels.reshape(len(channels), -1)
    samples = channels[:, column_number(recording, [], channels.shape[1])]
    place = in_array(recording, samples)
    if samples.dtype.kind in "iu":
        peak = 2.0 ** (8 * samples.dtype.itemsize - 1)
        samples = (samples - (peak if samples.dtype.kind == "u" else 0.0)) / peak
    others = [repr(str(k)) for k in range(channels.shape[1]) if str(k) != recording.column.strip()]
    head = f"channel {recording.column} of {len(others) + 1}; others by column: {', '.join(others)}" if others else ""
    by = "the header of the WAV file"
    return Column(samples, place, rate_hz=float(rate_hz), rate_by=by, full_scale=True, head=head)
