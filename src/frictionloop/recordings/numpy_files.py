"""Arrays of NumPy's files, NPY and NPZ; Python objects in them are never read, since reading one may run anything."""

from __future__ import annotations

import os
from typing import Any
from zipfile import ZipFile

import numpy as np

from frictionloop.parameters.sources import Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.arrays import picked, with_rate
from frictionloop.recordings.column import Column
from frictionloop.recordings.hdf5 import expands

ONLY = "array"
"""What the one array of a NPY file is called."""


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
