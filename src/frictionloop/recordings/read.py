"""A measured force: one column of a file, cut, scaled and brought to the rate of the loop."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from frictionloop.parameters.sources import Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.arrays import read_hdf5, read_mat, read_npy, read_npz, read_wav
from frictionloop.recordings.clean import clean_part
from frictionloop.recordings.clock import refuse_times
from frictionloop.recordings.column import Array, Column, refuse_gaps
from frictionloop.recordings.headers import scale_of
from frictionloop.recordings.part import Part, part_of, rows_until
from frictionloop.recordings.recorders import RECORDERS, read_recorder
from frictionloop.recordings.straight_lines import resampled
from frictionloop.recordings.text import read_text


def read_recording(recording: Recording, rate_hz: float, wanted: str = "N") -> Array:
    """Return the recorded force in newtons at t_k = k / rate_hz, from ``start_s`` to ``stop_s`` or the end.

        force = offset_n + f,  f = scale * column, |scale * column| with ``rectify``, less its mean if that is removed,

    the mean taken over the recorded samples used, of the magnitude if that is taken: the friction of strokes both ways
    has the mean of its magnitude. Both ends are included, so a window of D seconds gives
    D * rate_hz + 1 values (one less at the end of the file); ``start_s`` and ``stop_s`` are times of the column of
    times, or count from the first sample where there is none or it has dates, and fall on the nearest recorded sample
    (`window`). At the file's own rate the samples are copied exactly. At another they are resampled band-limited
    (`scipy.signal.resample_poly`; zero phase, flat to 0.8 of the lower of the two Nyquist frequencies, -100 dB above
    it) at a rational ratio right to 10 ppm; the straight line from the first to the last sample is set aside and put
    back, the rest mirrored at both ends, so that they do not ring.

    Parameters
    ----------
    recording
        Path and column. ``.csv .tsv .txt .dat .asc``: delimiter found by itself, lines of names and of units optional;
        lines that start with ``#`` are comments, and settings above the numbers ("# rate_hz: 1000", "unit: mN") are
        read; column by name, with or without its unit, or number from 0.
        ``.h5 .hdf5 .nc`` (NetCDF-4, packing undone) and ``.mat`` (5 and 7.3, indexed as in MATLAB but from 0): path
        of a dataset or its number, with ``[:, k]`` or ``[k, :]`` if it has two dimensions;
        ``.npz`` likewise, and ``.npy``, whose array is called "array". ``.wav``: channel; integers become -1 to 1 (full
        scale). ``.lvm``, ``.tdms``, ``.uff`` and ``.unv``, of the extra ``identify``: channel by name or number.
        The rate is ``recording.rate_hz``; WAV and files of recorders bring their own, and so does a file with a
        column of times ("t", "time_ms", "Time (s)"), or an array of them beside, whose steps agree within 0.1 %, or an
        attribute or number beside ("rate_hz", "fs", "dt"). Times without a unit are in s from 100 Hz to 1 MHz only.
        Uneven ones are brought to ``resample_hz`` (`straight_lines`).
    rate_hz
        Rate of the result in Hz, positive, at most 1e5 times above or below that of the file.
    wanted
        Unit of the result, "N", "V", "kg" or another of `quantities.units.UNITS`; a column whose header or attribute
        says a unit of that kind (mN) is scaled, one that says another kind needs ``recording.scale``.

    Returns
    -------
    Force in N, or what is wanted, shape (samples,).

    Raises
    ------
    FrictionloopError
        In one line: the file is missing, empty, damaged or of an unknown format; the column is not there (what
        is there is listed) or holds times; the unit is not known; the rate is missing, contradicts the file or is
        uneven in the part in use (with the line of the gap);
        a value in use is blank, not a number, not finite or in a row of too many cells (with its line or index);
        the window is past the end.
    """
    force, file_hz, _, _ = scaled(recording, wanted)
    return resampled(force, file_hz, rate_hz, recording.path)


def read_held(recording: Recording, rate_hz: float) -> Array:
    """Return the same in newtons with the last sample held for one of its own periods, as a signal of the loop.

    So 20 000 samples at 1 kHz last 20 s. A window that ``stop_s`` ends lasts no longer than it says.
    """
    taken = scaled(recording, "N")
    found = resampled(taken.force, taken.rate_hz, rate_hz, recording.path)
    held = math.floor(_lasts_s(recording, taken) * rate_hz + 1e-6) + 1 - found.size
    return np.pad(found, (0, max(held, 0)), mode="edge")


def lasting_s(recording: Recording) -> float:
    """Return how long the part in use lasts in s, its last sample held."""
    return _lasts_s(recording, scaled(recording, "N"))


def _lasts_s(recording: Recording, taken: Taken) -> float:
    begins_s, start_s = float(taken.part.at_s[0]), recording.start_s
    given = start_s is not None and start_s > begins_s - 1 / taken.rate_hz
    cut_s = math.inf if recording.stop_s is None else recording.stop_s - (start_s if given and start_s else begins_s)
    return min(taken.force.size / taken.rate_hz, cut_s)


class Taken(NamedTuple):
    """The part of a recording in use."""

    force: Array
    """In the unit that is wanted."""
    rate_hz: float
    column: Column
    """With what tells its rate."""
    part: Part


def scaled(recording: Recording, wanted: str) -> Taken:
    """Return the part in use in the wanted unit."""
    column = _open(recording)
    used, part = _used(recording, column)
    scale = recording.scale
    if scale is None and recording.unit is None and column.unit_in_doubt:
        raise FrictionloopError(f"{recording.path}: {column.unit_in_doubt}")
    if scale is None:
        where = f"{recording.path}: column {recording.column!r}"
        scale = scale_of(where, recording.unit, column.unit, wanted)
    if recording.rectify:
        used, scale = np.abs(used), abs(scale)
    if recording.remove_mean:
        used -= used.mean()
    column = replace(rows_until(column, part.stop), rate_by=part.by)
    return Taken(recording.offset_n + scale * used, part.rate_hz, column, part)


def _open(recording: Recording) -> Column:
    path = Path(recording.path)
    if path.is_dir():
        raise FrictionloopError(f"{path}: is a folder; accepted is a file: {' '.join(_READERS)}")
    if path.suffix.lower() not in _READERS:
        raise FrictionloopError(f"{path}: format {path.suffix!r} is unknown; accepted: {' '.join(_READERS)}")
    if not path.is_file():
        raise FrictionloopError(f"{path}: there is no such file")
    try:
        at, there = Path.cwd(), path.stat()
        column = _read(recording.path, recording.column, recording.decimal, at, there.st_mtime_ns, there.st_size)
    except FrictionloopError:
        raise
    except Exception as error:  # on a damaged file the libraries raise anything
        reason = (getattr(error, "strerror", None) or str(error) or type(error).__name__).splitlines()[0]
        raise FrictionloopError(f"{path}: cannot be read, empty or damaged ({reason:.120})") from None
    if not column.samples.size:
        raise FrictionloopError(f"{path}: column = {recording.column!r} holds no samples")
    refuse_times(recording, column)
    return column


@lru_cache(2)
def _read(path: str, column: str, decimal: Literal[".", ","], _at: Path, _changed: int, _size: int) -> Column:
    """Return a column of a file; the last two stay in memory, so that a run reads its two signals once."""
    return _READERS[Path(path).suffix.lower()](Recording(path=path, column=column, decimal=decimal))


def _used(recording: Recording, column: Column) -> tuple[Array, Part]:
    """Return the samples in use, and which they are."""
    part = part_of(recording, column)
    used = np.array(column.samples[part.first : part.stop], dtype=np.float64)
    where = clean_part(used, part.at_s)
    refuse_gaps(recording.path, used, lambda i: column.place(part.first + i), *where)
    if part.even_s is None:
        return used, part
    return np.interp(part.even_s, part.at_s, used), part._replace(at_s=part.even_s)


_READERS: Mapping[str, Callable[[Recording], Column]] = {
    **dict.fromkeys((".csv", ".tsv", ".txt", ".dat", ".asc"), read_text),
    **dict.fromkeys((".h5", ".hdf5", ".nc"), read_hdf5),
    ".mat": read_mat,
    ".npy": read_npy,
    ".npz": read_npz,
    ".wav": read_wav,
    **dict.fromkeys(RECORDERS, read_recorder),
}
