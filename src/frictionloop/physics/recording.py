"""A measured force: one column of a file, cut, scaled and brought to the rate of the loop."""

from __future__ import annotations

import csv
import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
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


def read_recording(recording: Recording, rate_hz: float) -> Array:
    """Return the recorded force in newtons at t_k = k / rate_hz, from ``start_s`` to ``stop_s`` or the end.

        force = offset_n + scale * column, or offset_n + scale * (column - mean) with ``remove_mean``,

    the mean taken over the recorded samples used. Both ends are included, so a window of D seconds gives
    D * rate_hz + 1 values (one less at the end of the file); ``start_s`` and ``stop_s``, counted from the first
    sample, fall on the nearest recorded one. At the file's own rate the samples are copied exactly. At another
    they are resampled band-limited (`scipy.signal.resample_poly`: zero-phase Kaiser low-pass below the lower of
    the two Nyquist frequencies; the straight line from first to last sample is set aside and put back, so that
    the ends do not ring), at a rational ratio right to 10 ppm.

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
    if recording.start_s * rate_hz > count - 0.5:
        raise FrictionloopError(f"{path}: start_s = {recording.start_s:g} is beyond the end; {lasts}")
    if recording.stop_s is not None and recording.stop_s * rate_hz > count + 0.5:
        raise FrictionloopError(f"{path}: stop_s = {recording.stop_s:g} is beyond the end; {lasts}")
    first = round(recording.start_s * rate_hz)
    stop = count if recording.stop_s is None else round(recording.stop_s * rate_hz) + 1
    used = np.array(column.decode(column.samples[first:stop]), dtype=np.float64)
    _refuse_gaps(recording, used, lambda i: column.place(first + i))
    return used, rate_hz


def _refuse_gaps(recording: Recording, values: Array, place: Callable[[int], str]) -> None:
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        more = f" (and {bad.size - 1} more)" if bad.size > 1 else ""
        raise FrictionloopError(f"{recording.path}: {place(bad[0])}{more}; accepted: a finite number")


def _resampled(force: Array, file_hz: float, rate_hz: float, path: str) -> Array:
    slower, faster = sorted((file_hz, rate_hz))
    if not 0 < faster <= _LARGEST_RATIO * slower:
        raise FrictionloopError(f"{path}: {file_hz:g} Hz cannot be resampled to {rate_hz:g} Hz; accepted: 1e5 apart")
    ratio = Fraction(slower / faster).limit_denominator(_LARGEST_RATIO)
    if ratio == 1:
        return force
    from scipy.signal import resample_poly

    up, down = ratio.as_integer_ratio() if rate_hz < file_hz else ratio.as_integer_ratio()[::-1]
    # The last t_k is the last one covered by the recording.
    return np.asarray(resample_poly(force, up, down, padtype="line")[: (force.size - 1) * up // down + 1])


def _read_text(recording: Recording) -> _Column:
    names, rows = _table(recording.path)
    first = next(rows, (0, names))
    width = len(names or first[1])
    k = _number_of(recording, recording.column, names, width)

    def values(k: int) -> Array:
        return np.fromiter((_number(cells, k) for _, cells in _table(recording.path)[1]), np.float64)

    def place(i: int, k: int = k) -> str:
        line, cells = next(islice(_table(recording.path)[1], i, None))
        cell = cells[k].strip() if k < len(cells) else ""
        return f"line {line}: {names[k] if names else f'column {k}'} is {f'{cell!r:.40}' if cell else 'blank'}"

    clock = next((names.index(name) for name in _TIME_NAMES if name in names), None)
    if recording.rate_hz is not None or clock is None:
        return _Column(values(k), place)
    times = values(clock)
    _refuse_gaps(recording, times, lambda i: place(i, clock))
    return _Column(values(k), place, _rate_of(recording, times, lambda i: place(i, clock)))


def _rate_of(recording: Recording, times: Array, place: Callable[[int], str]) -> float | None:
    if times.size < 2:
        return None
    steps = np.diff(times)
    usual = float(np.median(steps))
    uneven = np.flatnonzero((np.abs(steps - usual) > 1e-3 * abs(usual)) | (steps <= 0))
    if uneven.size:
        raise FrictionloopError(
            f"{recording.path}: {place(uneven[0] + 1)}, {steps[uneven[0]]:g} s after the line before: a gap; "
            f"accepted: even steps (most are {usual:g} s), or give rate_hz"
        )
    return float(f"{(times.size - 1) / (times[-1] - times[0]):.9g}")


def _table(path: str) -> tuple[list[str], Iterator[tuple[int, list[str]]]]:
    """Return the names (none without a header) and the rows of data, each with its line in the file."""
    rows = _rows(path)
    first = next(rows, None)
    if first is None:
        raise FrictionloopError(f"{path}: is empty")
    if any(np.isfinite(_number(first[1], k)) for k in range(len(first[1]))):
        return [], chain([first], rows)
    return [cell.strip() for cell in first[1]], dropwhile(lambda row: not row[1], rows)


def _rows(path: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the line number and cells of each line; none for a blank one, unless only blank ones follow."""
    with open(path, encoding="utf-8-sig", errors="replace", newline="") as stream:
        sample = [line.strip() for line in islice(stream, 100) if line.strip() and line.strip()[0] != "#"]
        delimiter = next((mark for mark in "\t;, " if sample and mark in sample[-1]), "\t")
        stream.seek(0)
        split = (lambda line: "\t".join(line.split())) if delimiter == " " else str
        lines = ("#" if line.lstrip().startswith("#") else split(line) for line in stream)
        reader = csv.reader(lines, delimiter="\t" if delimiter == " " else delimiter)
        blank: list[int] = []
        started = False
        for cells in reader:
            if cells == ["#"]:
                continue
            if not any(cell.strip() for cell in cells):
                blank += [reader.line_num] if started else []
                continue
            yield from ((line, []) for line in blank)
            blank, started = [], True
            yield reader.line_num, cells


def _number(cells: list[str], k: int) -> float:
    try:
        return float(cells[k])
    except (ValueError, IndexError):
        return np.nan
