"""What is in a file, before anything is computed from it: channels, rate, lost samples, and how they look."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionloop.findings import Condition, Finding, Result
from frictionloop.findings.result import Figure, Row, Tables
from frictionloop.identification.channel_summary import ChannelSummary, Glance, finite
from frictionloop.loop.progress import progress_bar
from frictionloop.quantities import FrictionloopError, replacing
from frictionloop.recordings.contents import Channel, Contents, blocks_of, count_blocks
from frictionloop.recordings.file_opening import read_contents
from frictionloop.recordings.sampling import Sampling, samplings_of
from frictionloop.recordings.text_numbers import Decimal

MOST = 12
"""Channels in the table that belongs to the answer."""
WINDOWS, ROWS = 100, 512
"""Windows that are looked at, and rows of each."""
DRAWN = 24
"""Channels that are drawn."""


class FileChannels(Result, schema="identify.channels/1"):
    """A file at a glance."""

    path: str
    date: str
    """ISO 8601."""
    dated: bool
    """Whether the file says its date; else it is the day on which it was last written."""
    rate_hz: float | None
    """None: a plain table, uneven times, or channels of several rates."""
    rate_from: str
    even: bool
    """Whether the times rise in equal steps."""
    gaps: tuple[tuple[int, int], ...]
    """Row before each gap in the times, and how many samples are missing there."""
    channels: tuple[ChannelSummary, ...]

    def rows(self) -> list[Row]:
        """Return file, date, rate and duration."""
        rate = "none" if self.rate_hz is None else f"{self.rate_hz:g} Hz ({self.rate_from})"
        rates = sorted({each.rate_hz for each in self.channels if each.rate_hz})
        rate = f"{', '.join(f'{each:g}' for each in rates)} Hz" if len(rates) > 1 else rate
        longest = max(each.samples for each in self.channels)
        lasts = f"{longest} samples" + (f", {longest / self.rate_hz:.4g} s" if self.rate_hz else "")
        date = ("recorded" if self.dated else "written", self.date)
        found = [("file", Path(self.path).name), date, ("rate", rate), ("lasts", lasts)]
        more = len(self.channels) - MOST
        return [*found, ("channels", f"{MOST} of {len(self.channels)}: --all")] if more > 0 else found

    def tables(self) -> Tables:
        """Return range, rms about the mean and type of each channel."""
        import pandas as pd  # type: ignore[import-untyped]

        names = {"name": "channel", "least": "from", "most": "to"}
        left = ["clipped", "wraps", "missing", "first_missing", "both_signs"]
        left += ["rate_hz"] if len({each.rate_hz for each in self.channels if each.rate_hz}) < 2 else []
        frame = pd.DataFrame(self.channels).drop(columns=left).rename(columns=names).set_index("channel")
        parts = {"channels": frame.head(MOST), "further channels": frame.iloc[MOST:]}
        return {name: part for name, part in parts.items() if len(part)}

    def plot(self) -> Figure:
        """Return the range of each channel in short windows along the file."""
        return first_look(self.path, self.rate_hz).plot()

    def channel_map(self) -> str:
        """Return a channel map in TOML with every channel of the file, to be renamed, filled in and cut down."""
        lines = [f"# {Path(self.path).name}: name f_m, mass, ..."]
        lines += ["# rate_hz = 1000.0"] if self.rate_hz is None else []
        for k, each in enumerate(self.channels):
            name, unit = (json.dumps(text, ensure_ascii=False) for text in (each.name, each.unit))  # as TOML has texts
            lines += ["", f"[channels.channel_{k}]", f"column = {name}"]
            lines.append(f"unit = {unit}" if each.unit else '# unit = "V"')
            lines += ["# scale = 1.0", "# sign = -1", "# zero_s = [0.0, 1.0]"]
        return "\n".join(lines) + "\n"

    def write_map(self, path: str | os.PathLike[str]) -> None:
        """Write `channel_map` to a file."""
        with replacing(path) as beside:
            beside.write_text(self.channel_map(), encoding="utf-8")


def channels(
    path: str | os.PathLike[str],
    rate_hz: float | None = None,
    progress: bool | None = None,
    decimal: Decimal | None = None,
) -> FileChannels:
    """Return what a file holds; of a large one every sample is looked at, block by block.

    Parameters
    ----------
    path : path
        File of any known format.
    rate_hz : float, optional
        Sampling rate in Hz, where the file tells none or two.
    progress : bool, optional
        Whether to show a progress bar; None: on a terminal, for a file that is large.
    decimal : str, optional
        Decimal mark of a text, where its numbers can be read in two ways.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, or one that tells two rates.
    """
    contents = read_contents(path, decimal)
    signals = contents.signals() or contents.channels
    each_of = samplings_of(str(path), signals, rate_hz)
    rates = {each.rate_hz for each in each_of.values()}
    first = max(signals, key=lambda line: line.samples.size)
    sampling = each_of[first.name]
    seen = _summaries(contents.channels, {name: each.rate_hz for name, each in each_of.items()}, progress)
    return FileChannels(
        path=str(path),
        date=contents.date,
        dated=contents.dated,
        rate_hz=sampling.rate_hz if len(rates) == 1 else None,
        rate_from=sampling.source,
        even=sampling.even,
        gaps=sampling.gaps,
        channels=seen,
        findings=(*_findings(contents, sampling, rates), *(each for one in seen for each in one.findings())),
    )


def _summaries(
    lines: Sequence[Channel], rates_hz: Mapping[str, float | None], progress: bool | None
) -> tuple[ChannelSummary, ...]:
    found = [Glance(line) for line in lines]
    total = max(count_blocks(line.samples) for line in lines)
    show = progress if total > 1 else False
    with progress_bar("looking through the file", 2 * total, show) as bar:
        for take in (Glance.first, Glance.second):
            # Block by block through all channels, since a file usually has them side by side.
            for blocks in zip_longest(*(blocks_of(line.samples) for line in lines)):
                for each, block in zip(found, blocks, strict=True):
                    if block is not None:
                        take(each, block)
                bar()
    return tuple(each.result(rates_hz.get(each.line.name)) for each in found)


def _findings(contents: Contents, sampling: Sampling, rates_hz: set[float | None]) -> Iterator[Finding]:
    yield from contents.findings
    if rates_hz == {None} and sampling.even:
        yield Finding("RATE-UNKNOWN", remedy="rate_hz in the map")
    if sampling.gaps:
        lost = sum(count for _, count in sampling.gaps)
        more = {"row": sampling.gaps[0][0], "gaps": len(sampling.gaps)}
        yield Finding("DATA-GAPS", value=lost, where=Condition(channel="times"), more=more)
    if not sampling.even:
        yield Finding("TIMES-UNEVEN", value=1e3 * sampling.uneven_s, unit="ms", remedy="resample_hz")
    sizes = sorted({line.samples.size for line in contents.signals()})
    for size in sizes[:-1]:
        names = [line.name for line in contents.signals() if line.samples.size == size]
        reason = {"reason": f"{size} samples, others {sizes[-1]}"}
        yield Finding("LEFT-OUT", value=len(names), where=Condition(channel=", ".join(names)), more=reason)


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
        known = finite(np.concatenate([self.low, self.high]))
        return not known.size or bool(known.min() == known.max())


class FirstLook(NamedTuple):
    """What is seen of a file at once."""

    path: str
    traces: tuple[Trace, ...]
    said: str
    """How much of the file was looked at."""
    rate_hz: float | None
    """Of the samples, None where nothing tells it."""

    def drawn(self) -> list[Trace]:
        """Return the first of the channels that vary, of all where none does."""
        return ([trace for trace in self.traces if not trace.constant] or list(self.traces))[:DRAWN]

    def plot(self) -> Figure:
        """Return the channels that vary, one below the other, each by its lowest and highest value along the file."""
        from frictionloop.figures.style import styled

        return styled(_drawn)(self)


def first_look(path: str | os.PathLike[str], rate_hz: float | None = None, decimal: Decimal | None = None) -> FirstLook:
    """Return the range of each channel in windows all along a file; a rate in Hz, a decimal mark.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read.
    """
    contents = read_contents(path, decimal)
    signals = contents.signals() or contents.channels
    sizes = dict.fromkeys(line.samples.size for line in signals)
    found = [each for size in sizes for each in _traces([line for line in signals if line.samples.size == size])]
    seen = f"{WINDOWS} windows, {f'{ROWS} samples each' if max(sizes) > WINDOWS * ROWS else 'all samples'}"
    every: set[Sampling] = set()
    with suppress(FrictionloopError):  # two rates, of which neither is drawn
        every = {*samplings_of(str(path), signals, rate_hz).values()}
    # Else rows are no seconds, or not the same ones.
    at_hz = next((each.rate_hz for each in every if len(every) == 1 and each.even and not each.gaps), None)
    return FirstLook(str(path), tuple(found), seen, at_hz)


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
    fine = finite(window)
    return (float(fine.min()), float(fine.max())) if fine.size else (np.nan, np.nan)


def _drawn(look: FirstLook) -> Figure:
    from frictionloop.figures.style import BLUE, new_figure

    traces = look.drawn()
    figure = new_figure(8.0, 1.0 + 0.9 * len(traces))
    rows = figure.subplots(len(traces), 1, sharex=True, squeeze=False)[:, 0]
    for axes, trace in zip(rows, traces, strict=True):
        axes.fill_between(
            trace.row / (look.rate_hz or 1.0), trace.low, trace.high, color=BLUE, linewidth=0.6, edgecolor=BLUE
        )
        name = f"{trace.name}\n({trace.unit})" if trace.unit else trace.name
        axes.set_ylabel(name, rotation=0, ha="right", va="center")
        axes.margins(x=0.0, y=0.1)
    rows[-1].set_xlabel("time (s)" if look.rate_hz else "sample")
    rows[0].set_title(f"{Path(look.path).name}: {look.said}", loc="left", fontsize="small")
    return figure
