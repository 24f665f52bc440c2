"""A measured force: one column of a file, cut, scaled and brought to the rate of the loop."""

from __future__ import annotations

import csv
import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import chain, dropwhile, islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionloop.parameters.sources import Recording
from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]

_LARGEST_RATIO = 100_000  # terms of the resampling ratio: right to 10 ppm, finer than the clocks of recorders
_TIME_NAMES = ("time", "time_s", "t")
_LINE = re.compile(r"(.*?)\s*(?:\[\s*(?::\s*,\s*(\d+)|(\d+)\s*,\s*:)\s*\])?", re.DOTALL)
_SHOWN = 20  # names listed in an error


def read_recording(recording: Recording, rate_hz: float) -> Array:
    """Return the recorded force in newtons at t_k = k / rate_hz, from ``start_s`` to ``stop_s`` or the end.

        force = offset_n + scale * column, or offset_n + scale * (column - mean) with ``remove_mean``,

    the mean taken over the recorded samples used. Both ends are included, so a window of D seconds gives
    D * rate_hz + 1 values (one less at the end of the file); ``start_s`` and ``stop_s``, counted from the first
    sample, fall on the nearest recorded one. At the file's own rate the samples are copied exactly. At another
    they are resampled band-limited (`scipy.signal.resample_poly`; zero phase, flat to 0.8 of the lower of the
    two Nyquist frequencies, -100 dB above it) at a rational ratio right to 10 ppm; the straight line from the
    first to the last sample is set aside and put back, the rest mirrored at both ends, so that they do not ring.

    Parameters
    ----------
    recording
        Path and column. ``.csv .tsv .txt``: delimiter found by itself, one line of names optional, lines
        starting with ``#`` are comments; column by name or number from 0. ``.h5 .hdf5 .nc`` (NetCDF-4, packing
        undone) and ``.mat`` (5 and 7.3, indexed as in MATLAB but from 0): path of a dataset or its number, with
        ``[:, k]`` or ``[k, :]`` if it has two dimensions. ``.wav``: channel; integers become -1 to 1 (full
        scale). The rate is ``recording.rate_hz``; a WAV brings its own, and so does a text file with a column
        of seconds named time, time_s or t whose steps agree within 0.1 %.
    rate_hz
        Rate of the result in Hz, positive, at most 1e5 times above or below that of the file.

    Returns
    -------
    Force in N, shape (samples,).

    Raises
    ------
    FrictionloopError
        In one line: the file is missing, empty, damaged or of an unknown format; the column is not there (what
        is there is listed); the rate is missing, contradicts the file or is uneven (with the line of the gap);
        a value in use is blank, not a number or not finite (with its line or index); the window is past the end.
    """
    column = _open(recording)
    used, file_hz = _used(recording, column)
    if recording.remove_mean:
        used -= used.mean()
    return _resampled(recording.offset_n + recording.scale * used, file_hz, rate_hz, recording.path)


@dataclass(frozen=True)
class _Column:
    samples: NDArray[Any]
    place: Callable[[int], str]
    """How the file calls sample i, and what stands there."""
    rate_hz: float | None = None
    decode: Callable[[NDArray[Any]], NDArray[Any]] = np.asarray
    """From what is stored to the column's unit."""


def _open(recording: Recording) -> _Column:
    path = Path(recording.path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise FrictionloopError(f"{path}: format {path.suffix!r} is unknown; accepted: {' '.join(_READERS)}")
    if not path.is_file():
        raise FrictionloopError(f"{path}: there is no such file")
    try:
        column = reader(recording)
    except FrictionloopError:
        raise
    except Exception as error:  # on a damaged file the libraries raise anything
        reason = (getattr(error, "strerror", None) or str(error) or type(error).__name__).splitlines()[0]
        raise FrictionloopError(f"{path}: cannot be read, empty or damaged ({reason:.120})") from None
    if not column.samples.size:
        raise FrictionloopError(f"{path}: column = {recording.column!r} holds no samples")
    return column


def _used(recording: Recording, column: _Column) -> tuple[Array, float]:
    path, rate_hz, count = recording.path, column.rate_hz or recording.rate_hz, column.samples.size
    if rate_hz is None:
        raise FrictionloopError(f"{path}: rate_hz is missing; accepted: the sampling rate of the file in Hz")
    if recording.rate_hz not in (None, rate_hz):
        raise FrictionloopError(
            f"{path}: rate_hz = {recording.rate_hz:g} contradicts the file; accepted: {rate_hz:g} or none"
        )
    lasts = f"the recording lasts {count / rate_hz:g} s ({count} samples at {rate_hz:g} Hz)"
    if recording.start_s * rate_hz >= count - 0.5:
        raise FrictionloopError(f"{path}: start_s = {recording.start_s:g} is beyond the end; {lasts}")
    if recording.stop_s is not None and recording.stop_s * rate_hz > count + 0.5:
        raise FrictionloopError(f"{path}: stop_s = {recording.stop_s:g} is beyond the end; {lasts}")
    first = round(recording.start_s * rate_hz)
    stop = count if recording.stop_s is None else round(recording.stop_s * rate_hz) + 1
    used = np.array(column.decode(column.samples[first:stop]), dtype=np.float64)
    _refuse_gaps(path, used, lambda i: column.place(first + i))
    return used, rate_hz


def _refuse_gaps(path: str, values: Array, place: Callable[[int], str]) -> None:
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        more = f" (and {bad.size - 1} more)" if bad.size > 1 else ""
        raise FrictionloopError(f"{path}: {place(bad[0])}{more}; accepted: a finite number")


def _resampled(force: Array, file_hz: float, rate_hz: float, path: str) -> Array:
    slower, faster = sorted((file_hz, rate_hz))
    if not 0 < faster <= _LARGEST_RATIO * slower:
        raise FrictionloopError(
            f"{path}: {file_hz:g} Hz cannot be resampled to {rate_hz:g} Hz; "
            f"accepted: {file_hz / _LARGEST_RATIO:g} to {file_hz * _LARGEST_RATIO:g} Hz"
        )
    ratio = Fraction(slower / faster).limit_denominator(_LARGEST_RATIO)
    if ratio == 1 or force.size == 1:
        return force
    from scipy.signal import firwin, kaiser_beta, resample_poly

    up, down = ratio.as_integer_ratio() if rate_hz < file_hz else ratio.as_integer_ratio()[::-1]
    # 32 samples of the lower rate to each side: 100 dB in a band of 0.2 of its Nyquist frequency.
    low_pass = firwin(64 * max(up, down) + 1, 0.9 / max(up, down), window=("kaiser", kaiser_beta(100)))
    line = np.linspace(force[0], force[-1], force.size)
    around = resample_poly(force - line, up, down, window=low_pass, padtype="antireflect")
    # The last t_k is the last one that the recording covers.
    k = np.arange((force.size - 1) * up // down + 1)
    return np.asarray(around[: k.size] + np.interp(k * (down / up), np.arange(force.size), line))


def _read_text(recording: Recording) -> _Column:
    path = recording.path
    names, rows = _table(path)
    k = _number_of(recording, names, len(names or next(rows)[1]))

    def values(k: int) -> Array:
        return np.fromiter((_number(cells, k) for _, cells in _table(path)[1]), np.float64)

    def place(i: int, k: int) -> str:
        line, cells = next(islice(_table(path)[1], i, None))
        cell = cells[k].strip() if k < len(cells) else ""
        return f"line {line}: {names[k] if names else f'column {k}'} is {f'{cell!r:.40}' if cell else 'blank'}"

    clock = next((names.index(name) for name in _TIME_NAMES if name in names), None)
    if k == clock:
        others = ", ".join(repr(name) for name in names if name not in _TIME_NAMES)
        raise FrictionloopError(f"{path}: column = {recording.column!r} holds times; accepted: {others or 'a force'}")
    file_hz = None
    if recording.rate_hz is None and clock is not None:
        file_hz = _rate_of(path, values(clock), partial(place, k=clock))
    return _Column(values(k), partial(place, k=k), file_hz)


def _rate_of(path: str, times: Array, place: Callable[[int], str]) -> float | None:
    """Return the rate of a column of times in s, None if it is too short to tell."""
    _refuse_gaps(path, times, place)
    if times.size < 2:
        return None
    steps = np.diff(times)
    usual = float(np.median(steps))
    uneven = np.flatnonzero((np.abs(steps - usual) > 1e-3 * abs(usual)) | (steps <= 0))
    if uneven.size:
        raise FrictionloopError(
            f"{path}: {place(uneven[0] + 1)}, {steps[uneven[0]]:g} s after the row before: a gap; "
            f"accepted: even steps (most are {usual:g} s), or rate_hz given"
        )
    return float(f"{(times.size - 1) / (times[-1] - times[0]):.9g}")


def _table(path: str) -> tuple[list[str], Iterator[tuple[int, list[str]]]]:
    """Return the names (none without a header) and the rows of data, each with its line in the file."""
    rows = _rows(path)
    first = next(rows, None)
    if first is None:
        raise FrictionloopError(f"{path}: is empty; accepted: rows of numbers")
    if any(map(_is_number, first[1])):
        return [], chain([first], rows)
    return [cell.strip() for cell in first[1]], dropwhile(lambda row: not row[1], rows)


def _rows(path: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the line number and the cells of each row; no cells for a blank line with more rows after it."""
    with open(path, encoding="utf-8-sig", errors="replace", newline="") as stream:
        sample = [line.strip() for line in islice(stream, 100) if line.strip() and not _is_comment(line)]
        mark = next((mark for mark in "\t;, " if sample and mark in sample[-1]), "\t")
        stream.seek(0)
        tidy = (lambda line: "\t".join(line.split())) if mark == " " else str
        reader = csv.reader(
            ("#" if _is_comment(line) else tidy(line) for line in stream),
            delimiter="\t" if mark == " " else mark,
        )
        blank: list[int] | None = None
        for cells in reader:
            if cells == ["#"]:
                continue
            if any(cell.strip() for cell in cells):
                yield from ((line, []) for line in blank or [])
                blank = []
                yield reader.line_num, cells
            elif blank is not None:
                blank.append(reader.line_num)


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith("#")


def _number(cells: list[str], k: int) -> float:
    try:
        return float(cells[k])
    except (ValueError, IndexError):
        return np.nan


def _is_number(cell: str) -> bool:
    return not np.isnan(_number([cell], 0)) or cell.strip().lower().lstrip("+-") == "nan"


def _number_of(recording: Recording, names: list[str], count: int) -> int:
    """Return the number of the column that is asked for by name or by number."""
    column = recording.column.strip()
    if column in names:
        return names.index(column)
    if column.isdecimal() and int(column) < count:
        return int(column)
    raise _no_column(recording, [*map(repr, filter(None, names)), f"a number from 0 to {count - 1}"])


def _no_column(recording: Recording, there: list[str]) -> FrictionloopError:
    shown = ", ".join(there[:_SHOWN]) + (f" and {len(there) - _SHOWN} more" if len(there) > _SHOWN else "")
    return FrictionloopError(
        f"{recording.path}: column = {recording.column!r} is not there; accepted: {shown or 'nothing in this file'}"
    )


def _read_wav(recording: Recording) -> _Column:
    from scipy.io import wavfile

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wavfile.WavFileWarning)
        warnings.filterwarnings("error", "Reached EOF", wavfile.WavFileWarning)
        rate_hz, channels = wavfile.read(recording.path)
    channels = channels.reshape(len(channels), -1)
    samples = channels[:, _number_of(recording, [], channels.shape[1])]
    middle, peak = 0.0, 1.0
    if samples.dtype.kind in "iu":
        peak = 2.0 ** (8 * samples.dtype.itemsize - 1)
        middle = peak if samples.dtype.kind == "u" else 0.0
    return _Column(samples, _in_array(recording, samples), float(rate_hz), lambda x: (x - middle) / peak)


def _read_hdf5(recording: Recording) -> _Column:
    import h5py

    arrays: dict[str, Any] = {}
    with h5py.File(recording.path) as file:
        file.visititems(lambda name, item: arrays.update({name: item} if isinstance(item, h5py.Dataset) else {}))
        array, samples = _pick(recording, arrays, in_matlab=recording.path.lower().endswith(".mat"))
        packing = dict(array.attrs)
    return _Column(samples, _in_array(recording, samples), decode=partial(_unpacked, packing=packing))


def _unpacked(stored: NDArray[Any], packing: Mapping[str, Any]) -> NDArray[Any]:
    """Undo the packing of the NetCDF conventions: what is missing becomes NaN."""
    values = stored
    if "_FillValue" in packing:
        values = np.where(stored == packing["_FillValue"], np.nan, stored)
    if "scale_factor" in packing:
        values = values * packing["scale_factor"]
    return values + packing["add_offset"] if "add_offset" in packing else values


def _read_mat(recording: Recording) -> _Column:
    import h5py
    from scipy.io import loadmat, whosmat

    if h5py.is_hdf5(recording.path):
        return _read_hdf5(recording)
    variable = re.split(r"[/\[]", recording.column)[0].strip()
    # The variable asked for alone in memory; all of them to find one by number or to list them.
    known = variable in [name for name, _, _ in whosmat(recording.path, appendmat=False)]
    tree = loadmat(recording.path, appendmat=False, variable_names=[variable] if known else None)
    _, samples = _pick(recording, dict(_flat(tree)))
    return _Column(samples, _in_array(recording, samples))


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
        raise _no_column(recording, [f"{name!r} ({size})" for name, size in zip(shapes, sizes, strict=True)])
    array, shape = arrays[name], shapes[name]
    if column is None and row is None and (len(shape) == 1 or 1 in shape):
        return array, np.ravel(array[()])
    axis, k = (0, int(row)) if row is not None else (1, int(column or shape[-1]))
    if len(shape) == 1:
        raise _no_column(recording, [repr(name)])
    if k >= shape[axis]:
        raise _no_column(recording, [f"'{name}[:, 0]' to '{name}[:, {shape[1] - 1}]' or a row '{name}[0, :]'"])
    return array, array[(slice(None), k)[:: order if axis else -order]]


def _in_array(recording: Recording, samples: NDArray[Any]) -> Callable[[int], str]:
    return lambda i: f"column {recording.column!r} at index {i} is {samples[i]}"


_READERS: Mapping[str, Callable[[Recording], _Column]] = {
    **dict.fromkeys((".csv", ".tsv", ".txt"), _read_text),
    **dict.fromkeys((".h5", ".hdf5", ".nc"), _read_hdf5),
    ".mat": _read_mat,
    ".wav": _read_wav,
}
