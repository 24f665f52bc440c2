"""Whole binary files: HDF5 and NetCDF-4, MAT 5 and 7.3, NPZ, WAV."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from frictionloop.findings import Finding
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.arrays import check_mat
from frictionloop.recordings.contents import Channel, Contents, left_out, lines_of, told_date, told_rates
from frictionloop.recordings.hdf5 import check_hdf5, expands
from frictionloop.recordings.headers import attribute_unit, is_bare_dimension, unpacked
from frictionloop.recordings.stored import is_large
from frictionloop.recordings.stored_lines import hdf5_lines, wav_line

_CREATED = re.compile(rb"Created on: (\w{3} \w{3} [\d :]{8,16})")
"""Where the header of a MAT file says its date."""


def wav_contents(path: Path) -> Contents:
    """Return the channels of a WAV file; integers become -1 to 1 (full scale)."""
    from scipy.io import wavfile

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wavfile.WavFileWarning)
        warnings.filterwarnings("error", "Reached EOF", wavfile.WavFileWarning)
        large = is_large(path, path.stat().st_size, 1)
        try:
            rate_hz, values = wavfile.read(path, mmap=large)
        except ValueError:  # 24 bits cannot be mapped
            large = False
            rate_hz, values = wavfile.read(path)
    values = values.reshape(len(values), -1)
    scale = 1.0 if values.dtype.kind in "iu" else None
    lines = [wav_line(path, values, k, _of_full_scale) if large else values[:, k] for k in range(values.shape[1])]
    channels = (
        Channel(str(k), line if large else _of_full_scale(np.asarray(line)), None, scale)
        for k, line in enumerate(lines)
    )
    return Contents(tuple(channels), {"the header of the WAV file": float(rate_hz)})


def _of_full_scale(values: NDArray[Any]) -> NDArray[Any]:
    """Return integers as shares of their full scale, -1 to 1; other numbers as they are."""
    if values.dtype.kind not in "iu":
        return values
    peak = 2.0 ** (8 * values.dtype.itemsize - 1)
    return np.asarray((values - (peak if values.dtype.kind == "u" else 0.0)) / peak)


def npz_contents(path: Path) -> Contents:
    """Return the arrays of a NPZ file; Python objects in it are left out, since reading one may run anything."""
    arrays: dict[str, NDArray[Any]] = {}
    found: list[Finding] = []
    with ZipFile(path) as packed:  # what an array says of itself beyond this is an error of NumPy's
        if wrong := expands(path.stat().st_size, sum(each.file_size for each in packed.infolist())):
            raise FrictionloopError(f"{path}: {wrong}")
    with np.load(path, allow_pickle=False) as file:
        for name in file.files:
            try:
                arrays[name] = file[name]
            except ValueError:
                found.append(left_out(name, "a Python object"))
    return replace(_of_arrays(arrays), findings=tuple(found))


def hdf5_contents(path: Path) -> Contents:
    """Return the datasets of an HDF5 or NetCDF-4 file, and of a MAT file of version 7.3, which is transposed."""
    import h5py

    check_hdf5(str(path))
    arrays: dict[str, NDArray[Any]] = {}
    units: dict[str, str | None] = {}
    said: list[tuple[str, Any]] = []
    dropped: list[Finding] = []
    large: list[Channel] = []
    matlab = path.suffix.lower() == ".mat"

    def look(name: str, item: Any) -> None:
        said.extend((f"{name}@{key}", value) for key, value in item.attrs.items())
        if not isinstance(item, h5py.Dataset) or name.startswith("#") or is_bare_dimension(item):
            return
        if matlab and _class_of(item) not in ("", "double", "single", "logical") and "int" not in _class_of(item):
            if _class_of(item) not in ("char", "cell"):
                dropped.append(left_out(name, f"a MATLAB object ({_class_of(item)})"))
            return
        if item.dtype.kind in "iufbc" and item.ndim <= 2:
            if is_large(path, item.size, item.dtype.itemsize):
                large.extend(hdf5_lines(path, name, item, attribute_unit(dict(item.attrs)), unpacked))
                return
            values = unpacked(item[()], dict(item.attrs))
            arrays[name] = np.asarray(values).T if matlab else np.asarray(values)
            units[name] = attribute_unit(dict(item.attrs))

    with h5py.File(path) as file:
        said.extend(file.attrs.items())
        file.visititems(look)
    said = [(name.rpartition("@")[2], value) for name, value in said]
    found = _of_arrays(arrays, units)
    return Contents((*found.channels, *large), told_rates(said) | dict(found.rates_hz), tuple(dropped), told_date(said))


def mat_contents(path: Path) -> Contents:
    """Return the arrays of a MAT file, those in structures as structure/field; opaque MATLAB objects are left out.

    SciPy's list of what a file holds (``whosmat``) fails on such objects; reading the whole file does not.
    """
    import h5py
    from scipy.io import loadmat

    with open(path, "rb") as stream:
        created = _CREATED.search(stream.read(128))
    date = created[1].decode("ascii", "replace").strip() if created else ""
    if h5py.is_hdf5(path):
        found = hdf5_contents(path)
        return replace(found, date=found.date or date)
    check_mat(str(path))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        tree = loadmat(path, appendmat=False)
    dropped: list[Finding] = []
    arrays = dict(_leaves({name: value for name, value in tree.items() if not str(name).startswith("__")}, dropped))
    found = _of_arrays(arrays)
    return Contents(found.channels, found.rates_hz, tuple(dropped), date)


def _class_of(item: Any) -> str:
    name = item.attrs.get("MATLAB_class", b"")
    return name.decode() if isinstance(name, bytes) else str(name)


def _leaves(tree: Mapping[Any, Any], dropped: list[Finding], prefix: str = "") -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield the arrays of a MAT file by their path; what is an object is dropped."""
    from scipy.io.matlab import MatlabFunction, MatlabOpaque

    for name, value in tree.items():
        full = f"{prefix}{name}"
        if isinstance(value, (MatlabOpaque, MatlabFunction)) or name in (None, "None"):
            dropped.append(left_out("unnamed" if name in (None, "None") else full, "a MATLAB object"))
        elif isinstance(value, np.ndarray) and value.dtype.names:
            for k, each in enumerate(value.flat):
                inside = {field: each[field] for field in value.dtype.names}
                yield from _leaves(inside, dropped, f"{full}/" if value.size == 1 else f"{full}({k + 1})/")
        elif isinstance(value, np.ndarray) and value.dtype.kind == "O":
            for k, each in enumerate(value.flat):
                yield from _leaves({f"{{{k + 1}}}": each}, dropped, full)
        elif isinstance(value, np.ndarray):
            yield full, value


def _of_arrays(arrays: Mapping[str, NDArray[Any]], units: Mapping[str, str | None] | None = None) -> Contents:
    channels = [line for name, array in arrays.items() for line in lines_of(name, array, (units or {}).get(name))]
    return Contents(tuple(channels), told_rates(arrays.items()), date=told_date(arrays.items()))
