"""A first look at a file, in seconds whatever its size: the range of each channel in short windows all along it."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionloop.identification.sampling import sampling_of
from frictionloop.recordings.contents import Channel, Contents
from frictionloop.recordings.stored import LARGE_BYTES
from frictionloop.recordings.table_layout import layout_of
from frictionloop.recordings.table_rows import rows_in
from frictionloop.recordings.tables import read_table
from frictionloop.recordings.whole import READERS, read_contents

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WINDOWS, ROWS = 100, 512
"""Windows that are looked at, and rows of each."""
DRAWN = 24
"""Channels that are drawn."""
HEAD_BYTES = 2**18
"""Bytes of a large text file from which its columns and the length of a row are taken."""


class Trace(NamedTuple):
    """A channel in windows; arrays of one shape."""

    name: str
    unit: str
    row: NDArray[np.float64]
    """Middle of each window."""
    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @property
    def constant(self) -> bool:
        """Whether it never changes."""
        ends = np.concatenate([self.low, self.high])
        known = ends[np.isfinite(ends)]
        return not known.size or bool(known.min() == known.max())


class FirstLook(NamedTuple):
    """What is seen of a file at once."""

    path: str
    traces: tuple[Trace, ...]
    said: str
    """How much of the file was looked at."""
    rate_hz: float | None
    """Of the samples, None where nothing tells it."""
    clock: tuple[str, NDArray[np.float64]] | None = None
    """Name and values of a column of times that rise in uneven steps."""

    def drawn(self) -> list[Trace]:
        """Return the first of the channels that vary, of all where none does."""
        return ([trace for trace in self.traces if not trace.constant] or list(self.traces))[:DRAWN]

    def left_out(self) -> list[str]:
        """Return the names of the channels that are not drawn: they do not vary, or stand behind the first."""
        drawn = self.drawn()
        return [trace.name for trace in self.traces if not any(trace is each for each in drawn)]

    def along(self, row: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where rows stand in time, or as samples where nothing tells a rate."""
        if self.rate_hz:
            return row / self.rate_hz
        return row if self.clock is None else np.interp(row, np.arange(self.clock[1].size), self.clock[1])

    def plot(self) -> Figure:
        """Return the channels that vary, one below the other, each by its lowest and highest value along the file."""
        from frictionloop.figures.style import styled

        return styled(_drawn)(self)


def first_look(path: str | os.PathLike[str], rate_hz: float | None = None) -> FirstLook:
    """Return the range of each channel in windows all along a file; a rate in Hz where the file tells none or two.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read.
    """
    file = Path(path)
    if file.is_file() and READERS.get(file.suffix.lower()) is read_table and file.stat().st_size > LARGE_BYTES:
        traces, told_hz = _sparse(file)
        return FirstLook(str(path), tuple(traces), f"{WINDOWS} windows, {ROWS} rows each", rate_hz or told_hz)
    contents = read_contents(file)
    signals = contents.signals() or contents.channels
    sizes = dict.fromkeys(line.samples.size for line in signals)
    found = [each for size in sizes for each in _traces([line for line in signals if line.samples.size == size])]
    seen = f"{WINDOWS} windows, {f'{ROWS} samples each' if max(sizes) > WINDOWS * ROWS else 'all samples'}"
    at_hz = _rate_of(path, contents, rate_hz)
    return FirstLook(str(path), tuple(found), seen, at_hz, _rising(contents) if at_hz is None else None)


def _rising(contents: Contents) -> tuple[str, NDArray[np.float64]] | None:
    """Return the column of times of a file, if they rise; None else."""
    times = contents.clock()
    values = np.zeros(0) if times is None else np.asarray(times.samples[:], dtype=float)
    if times is None or values.size < 2 or not np.all(np.diff(values) > 0):
        return None
    return f"{times.name} ({times.unit})" if times.unit else times.name, values


def _rate_of(path: str | os.PathLike[str], contents: Contents, rate_hz: float | None = None) -> float | None:
    """Return the rate that a file tells by even times or a number; None else, for then rows are no seconds."""
    sampling = sampling_of(str(path), contents, rate_hz)
    return sampling.rate_hz if sampling.even and not sampling.gaps else None


def _sparse(file: Path) -> tuple[list[Trace], float | None]:
    """Return windows of a large text file, and the rate that its beginning tells.

    Rows are counted by their mean length: nothing before is read.
    """
    with tempfile.TemporaryDirectory() as folder:
        head = Path(folder) / file.name
        with open(file, "rb") as stream:
            head.write_bytes(stream.read(HEAD_BYTES).rpartition(b"\n")[0])
        begun = read_contents(head)
        rows = max(line.samples.size for line in begun.channels)
        row_bytes = head.stat().st_size / rows
    layout = layout_of(file)
    width, size = int(ROWS * row_bytes), file.stat().st_size
    signals = begun.signals() or begun.channels
    places = [begun.channels.index(line) for line in signals]
    middles, ends = [], []
    with open(file, "rb") as stream:
        for start in np.linspace(0, max(size - 2 * width, 0), WINDOWS).astype(int).tolist():
            stream.seek(start)
            lines = stream.read(width).split(b"\n")[1:-1]
            if start == 0:
                lines = lines[layout.first :]
            values = rows_in(file, b"\n".join(lines) + b"\n", layout)
            if values.shape[1] > max(places):
                middles.append((start + width / 2) / row_bytes)
                ends.append([_ends(values[:, k]) for k in places])
    low_high = np.array(ends)
    traces = [
        Trace(line.name, line.unit or "", np.array(middles), low_high[:, k, 0], low_high[:, k, 1])
        for k, line in enumerate(signals)
    ]
    return traces, _rate_of(file, begun)


def _traces(lines: Sequence[Channel]) -> tuple[Trace, ...]:
    """Return the windows of channels of one length; window by window, for a file has the channels side by side."""
    size = lines[0].samples.size
    width = max(min(size // WINDOWS, ROWS), 1) if size > WINDOWS * ROWS else -(-size // WINDOWS)
    starts = np.unique(np.linspace(0, max(size - width, 0), WINDOWS).astype(int))
    ends = np.array([[_ends(line.samples[k : k + width]) for line in lines] for k in starts.tolist()])
    return tuple(
        Trace(line.name, line.unit or "", starts + width / 2, ends[:, k, 0], ends[:, k, 1])
        for k, line in enumerate(lines)
    )


def _ends(window: NDArray[Any]) -> tuple[float, float]:
    real = np.abs(window) if window.dtype.kind == "c" else np.asarray(window, dtype=float)
    fine = real[np.isfinite(real)]
    return (float(fine.min()), float(fine.max())) if fine.size else (np.nan, np.nan)


def _drawn(look: FirstLook) -> Figure:
    from frictionloop.figures.style import BLUE, new_figure

    traces = look.drawn()
    figure = new_figure(8.0, 1.0 + 0.9 * len(traces))
    rows = figure.subplots(len(traces), 1, sharex=True, squeeze=False)[:, 0]
    for axes, trace in zip(rows, traces, strict=True):
        axes.fill_between(look.along(trace.row), trace.low, trace.high, color=BLUE, linewidth=0.6, edgecolor=BLUE)
        name = f"{trace.name}\n({trace.unit})" if trace.unit else trace.name
        axes.set_ylabel(name, rotation=0, ha="right", va="center")
        axes.margins(x=0.0, y=0.1)
    rows[-1].set_xlabel("time (s)" if look.rate_hz else look.clock[0] if look.clock else "sample")
    rows[0].set_title(f"{Path(look.path).name}: {look.said}", loc="left", fontsize="small")
    return figure
