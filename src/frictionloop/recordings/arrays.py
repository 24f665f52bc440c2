"""Columns of binary files: WAV, HDF5 and NetCDF-4, MAT 5 and 7.3."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionloop.parameters.sources import Recording
from frictionloop.quantities.scales import known_unit
from frictionloop.recordings.column import Column, column_number, no_column

_LINE = re.compile(r"(.*?)\s*(?:\[\s*(?::\s*,\s*(\d+)|(\d+)\s*,\s*:)\s*\])?", re.DOTALL)


def read_wav(recording: Recording) -> Column:
    """Return a channel of a WAV file; integers become -1 to 1 (full scale)."""
    from scipy.io import wavfile

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wavfile.WavFileWarning)
        warnings.filterwarnings("error", "Reached EOF", wavfile.WavFileWarning)
        rate_hz, channels = wavfile.read(recording.path)
    channels = channels.reshape(len(channels), -1)
    samples = channels[:, column_number(recording, [], channels.shape[1])]
    middle, peak = 0.0, 1.0
    if samples.dtype.kind in "iu":
        peak = 2.0 ** (8 * samples.dtype.itemsize - 1)
        middle = peak if samples.dtype.kind == "u" else 0.0
    return Column(samples, _in_array(recording, samples), float(rate_hz), decode=lambda x: (x - middle) / peak)


def read_hdf5(recording: Recording) -> Column:
    """Return a dataset, or a line of one, of an HDF5 or NetCDF-4 file."""
    import h5py

    arrays: dict[str, Any] = {}
    with h5py.File(recording.path) as file:
        file.visititems(lambda name, item: arrays.update({name: item} if isinstance(item, h5py.Dataset) else {}))
        array, samples = _pick(recording, arrays, in_matlab=recording.path.lower().endswith(".mat"))
        packing = dict(array.attrs)
    unit = known_unit(str(packing.get("units", packing.get("unit", ""))))
    return Column(samples, _in_array(recording, samples), unit=unit, decode=partial(_unpacked, packing=packing))


def _unpacked(stored: NDArray[Any], packing: Mapping[str, Any]) -> NDArray[Any]:
    """Undo the packing of the NetCDF conventions: what is missing becomes NaN."""
    values = stored
    if "_FillValue" in packing:
        values = np.where(stored == packing["_FillValue"], np.nan, stored)
    if "scale_factor" in packing:
        values = values * packing["scale_factor"]
    return values + packing["add_offset"] if "add_offset" in packing else values


def read_mat(recording: Recording) -> Column:
    """Return an array, or a line of one, of a MAT file of version 5 or 7.3."""
    import h5py
    from scipy.io import loadmat, whosmat

    if h5py.is_hdf5(recording.path):
        return read_hdf5(recording)
    variable = re.split(r"[/\[]", recording.column)[0].strip()
    # The variable asked for alone in memory; all of them to find one by number or to list them.
    known = variable in [name for name, _, _ in whosmat(recording.path, appendmat=False)]
    tree = loadmat(recording.path, appendmat=False, variable_names=[variable] if known else None)
    _, samples = _pick(recording, dict(_flat(tree)))
    return Column(samples, _in_array(recording, samples))


def _flat(tree: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield the arrays of a MAT file, those inside structures as structure/field."""
    for name, value in tree.items():
        if isinstance(value, np.ndarray) and value.dtype.names and value.size == 1:
            yield from _flat({field: value[field].flat[0] for field in value.dtype.names}, f"{prefix}{name}/")
        elif isinstance(value, np.ndarray):
            yield prefix + name, value


def _pick(recording: Recording, arrays: Mapping[str, Any], in_matlab: bool = False) -> tuple[Any, NDArray[Any]]:
    """Return the array that ``column`` names and the line of it that is asked for (MATLAB stores transposed)."""
    order = -1 if in_matlab else 1
    shapes = {
        name: array.shape[::order]
        for name, array in arrays.items()
        if array.dtype.kind in "iufb" and array.ndim in (1, 2) and not name.startswith("#")
    }
    match = _LINE.fullmatch(recording.column.strip())
    name, column, row = match.groups() if match else (recording.column, None, None)
    name = name.strip("/")
    if name not in shapes and name.isdecimal() and int(name) < len(shapes):
        name = list(shapes)[int(name)]
    if name not in shapes:
        sizes = [" x ".join(map(str, shape)) for shape in shapes.values()]
        raise no_column(recording, [f"{name!r} ({size})" for name, size in zip(shapes, sizes, strict=True)])
    array, shape = arrays[name], shapes[name]
    if column is None and row is None and (len(shape) == 1 or 1 in shape):
        return array, np.ravel(array[()])
    axis, k = (0, int(row)) if row is not None else (1, int(column or shape[-1]))
    if len(shape) == 1:
        raise no_column(recording, [repr(name)])
    if k >= shape[axis]:
        raise no_column(recording, [f"'{name}[:, 0]' to '{name}[:, {shape[1] - 1}]' or a row '{name}[0, :]'"])
    return array, array[(slice(None), k)[:: order if axis else -order]]


def _in_array(recording: Recording, samples: NDArray[Any]) -> Callable[[int], str]:
    return lambda i: f"column {recording.column!r} at index {i} is {samples[i]}"
