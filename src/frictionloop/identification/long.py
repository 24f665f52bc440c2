"""Recordings that do not fit in the memory, as the parts or the means that an analysis needs of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.identification.opened import Opened, findings_of, written
from frictionloop.identification.quiet_stretch import LOUD, PIECE_S
from frictionloop.identification.recording_columns import READING
from frictionloop.quantities import must_be
from frictionloop.recordings.contents import left_out

Array = NDArray[np.float64]
ROWS = 2**20
"""Rows that an analysis gets at once: of a channel in double precision 8 MiB, and some times as much for it."""
MEANS_HZ = 2000.0
"""Rate of the means that weights and slides are found in: far above what a finger or a hand moves by (assumed)."""
QUIET_S = 60.0
"""A longer quiet stretch tells a density no better than 1 in 1000 (assumed enough)."""
CALM_S = 0.2
"""A recording is cut in the middle of the calmest time of this length (assumed)."""


def is_long(file: Opened) -> bool:
    """Return whether a file is to be analysed in parts."""
    return file.stored and file.rate_hz is not None and file.rows > ROWS


def whole(file: Opened) -> xr.Dataset:
    """Return all of a recording."""
    return file.part(0, file.rows)


class Stretches(Sequence[xr.Dataset]):
    """A recording cut where it is calm: each part is read when it is asked for, and none of them is kept."""

    def __init__(self, file: Opened, column: str) -> None:
        self._file, self._ends = file, _cuts(file, column)
        self.data_vars = tuple(file.picked)
        self.attrs = file.part(0, 2).attrs

    def __len__(self) -> int:
        return len(self._ends) - 1

    def __getitem__(self, k: int) -> xr.Dataset:  # type: ignore[override]  # no slices
        if not 0 <= k < len(self):
            raise IndexError(k)
        return self._file.part(self._ends[k], self._ends[k + 1])


Run = xr.Dataset | Stretches


def _cuts(file: Opened, column: str) -> list[int]:
    """Return the rows at which parts begin: in the calmest time of the last quarter of what may be read at once."""
    calm = max(round(CALM_S * (file.rate_hz or 1.0)), 16)
    piece = max(calm // 100, 1)
    cuts = [0]
    while file.rows - cuts[-1] > ROWS:
        first = cuts[-1] + 3 * ROWS // 4
        signal = file.part(first, cuts[-1] + ROWS)[column].values
        pieces = signal[: signal.size // piece * piece].reshape(-1, piece)
        spans = pieces.max(axis=1) - pieces.min(axis=1)
        width = min(calm // piece, spans.size)
        loudest = np.lib.stride_tricks.sliding_window_view(spans, width).max(axis=1)
        cuts.append(first + (int(np.argmin(loudest)) + width // 2) * piece)
    return [*cuts, file.rows]


def means(file: Opened) -> xr.Dataset:
    """Return means of as many samples as bring the rate to 2 kHz; a mass, which jumps, as it stands there."""
    factor = max(int((file.rate_hz or 1.0) / MEANS_HZ), 1)
    parts = [_mean(part, factor) for part in _parts(file, ROWS // factor * factor)]
    joined = xr.concat(parts, "time", combine_attrs="override")
    time = np.arange(joined.sizes["time"]) * factor / (file.rate_hz or 1.0)
    return joined.assign_coords(time=("time", time, {"units": "s"}))


def _mean(part: xr.Dataset, factor: int) -> xr.Dataset:
    rows = part.sizes["time"] // factor

    def reduced(name: str) -> xr.Variable:
        cut = part[name].values[: rows * factor].reshape(rows, factor)
        return xr.Variable("time", cut[:, 0] if name == "mass" else cut.mean(axis=1), part[name].attrs)

    return xr.Dataset({str(name): reduced(str(name)) for name in part.data_vars}, attrs=part.attrs)


def calm(file: Opened, interval_s: tuple[float, float] | None = None) -> xr.Dataset:
    """Return what is to be analysed of a quiet recording: the interval, or a minute of its longest quiet stretch.

    Raises ``FrictionloopError`` for an interval outside the recording.
    """
    rate_hz = file.rate_hz or 1.0
    if interval_s is not None:
        first, stop = (round(end * rate_hz) for end in interval_s)
        if not 0 <= first < stop <= file.rows:
            raise must_be("interval_s", interval_s, f"rising within 0 to {file.rows / rate_hz:g}", "s")
    else:
        first, stop = _longest(file, max(round(PIECE_S * rate_hz), 8))
    stop = min(stop, first + round(QUIET_S * rate_hz))
    found = file.part(first, stop)
    rest = left_out("the rest", f"quiet enough: {first / rate_hz:.1f} to {stop / rate_hz:.1f} s")
    return found.assign_attrs(findings=written([*findings_of(found.attrs), rest]))


def _longest(file: Opened, piece: int) -> tuple[int, int]:
    """Return the rows of the longest stretch of pieces as quiet as the quietest quarter of them."""
    spread = []
    for part in _parts(file, ROWS // piece * piece):
        values = part[READING].values
        spread += values[: values.size // piece * piece].reshape(-1, piece).std(axis=1).tolist()
    still = np.array(spread)
    quiet = still < LOUD * np.median(np.sort(still)[: max(still.size // 4, 1)])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], quiet.astype(np.int8), [0]]))).reshape(-1, 2)
    first, stop = max(edges.tolist(), key=lambda pair: pair[1] - pair[0])
    return first * piece, stop * piece


def _parts(file: Opened, rows: int) -> Iterator[xr.Dataset]:
    for first in range(0, file.rows, rows):
        yield file.part(first, min(first + rows, file.rows))
