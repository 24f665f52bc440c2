"""A file of channels that is open: read as a whole, from row to row, or as what an analysis needs of a long one."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.findings import Finding
from frictionloop.findings.result import plain
from frictionloop.identification.project_file import (
    Channel,
    ChannelMap,
    Place,
    read_map,
    resampled,
    variable,
)
from frictionloop.identification.quiet import LOUD, PIECE_S
from frictionloop.identification.recording_columns import READING, runs_of
from frictionloop.quantities import check_known, must_be
from frictionloop.recordings import contents as found
from frictionloop.recordings.contents import Stored, find_channel, left_out
from frictionloop.recordings.file_opening import read_contents
from frictionloop.recordings.sampling import Sampling, sampling_of, samplings_of, told_by
from frictionloop.recordings.text_numbers import Decimal

TABLE_ROWS = 64
"""A file of at most so many rows that has no column of times is a table (assumed)."""
ROWS = 2**20
"""Rows that an analysis gets at once: of a channel in double precision 8 MiB, and some times as much for it."""
MEANS_HZ = 2000.0
"""Rate of the means that weights and slides are found in: far above what a finger or a hand moves by (assumed)."""
QUIET_S = 60.0
"""A longer quiet stretch tells a density no better than 1 in 1000 (assumed enough)."""
CALM_S = 0.2
"""A recording is cut in the middle of the calmest time of this length (assumed)."""


@dataclass(frozen=True)
class Opened:
    """The channels of a file that a map picks."""

    where: str
    contents: found.Contents
    picked: Mapping[str, found.Channel]
    chart: ChannelMap
    mapped: bool
    rate_hz: float | None
    """None of a table."""
    sha256: str
    rate_from: str
    resampled: tuple[Finding, ...] = ()
    """What was done to uneven times."""

    @property
    def rows(self) -> int:
        """Samples of a channel."""
        return max(line.samples.size for line in self.picked.values())

    @property
    def is_long(self) -> bool:
        """Whether it is to be analysed in parts: its samples are still in the file, and too many for once."""
        stored = any(isinstance(line.samples, Stored) for line in self.picked.values())
        return stored and self.rate_hz is not None and self.rows > ROWS

    @property
    def attrs(self) -> dict[str, str]:
        """Where the samples come from."""
        own = {"source": "recorded", "file": self.where, "sha256": self.sha256, "rate_from": self.rate_from}
        return own | {"date": f"{'' if self.contents.dated else 'file of '}{self.contents.date}"}

    def part(self, first: int, stop: int) -> xr.Dataset:
        """Return rows first to stop as a recording, as `load` returns all of them."""
        place = Place(first, stop, self.rate_hz or 1.0, "time" if self.rate_hz else "row", self.mapped)
        data = {
            name: variable(self.where, name, line, self.chart.channels[name], place)
            for name, line in self.picked.items()
        }
        data = {name: self._freed(name, data) for name in data}
        attributes = {**self.attrs, "findings": written([*self.resampled, *self._doubts(data)])}
        if not self.rate_hz:
            return xr.Dataset(data, attrs=attributes)
        samples = max(each.size for each in data.values())
        time = xr.Variable("time", (first + np.arange(samples)) / self.rate_hz, {"units": "s"})
        return xr.Dataset(data, {"time": time}, attributes)

    def whole(self) -> xr.Dataset:
        """Return all of it."""
        return self.part(0, self.rows)

    def _freed(self, name: str, data: Mapping[str, xr.Variable]) -> xr.Variable:
        """Return a channel less what it reads of the others."""
        found, others = data[name], [each for each in data if each != name]
        for other, share in self.chart.channels[name].crosstalk.items():
            check_known(f"{self.where}: channels.{name}.crosstalk", [other], others)
            found = found.copy(data=found.values - share * data[other].values)
        return found

    def _doubts(self, data: Mapping[str, xr.Variable]) -> Iterator[Finding]:
        """Yield what was found of the file, channels that no map chose, of other length or rate, and units not told."""
        yield from self.contents.findings_of(self.picked.values())
        taken, usual = {line.name for line in self.picked.values()}, told_by([*self.picked.values()])
        for line in () if self.mapped else self.contents.signals():
            if line.name not in taken:
                rates = told_by([line])
                hertz = "" if rates == usual else "".join(f", {each:g} Hz" for each in rates.values())
                yield found.left_out(line.name, f"{line.samples.size} samples{hertz}")
        for name, line in self.picked.items():
            unit = data[name].attrs["units"]
            told = self.chart.channels[name]
            if unit and not (line.unit or told.unit or told.gives) and told.scale is None:
                yield Finding("TAKEN-FOR", value=unit, more={"path": f"unit of {name}"})


def opened(
    path: str | os.PathLike[str],
    channels: ChannelMap | Mapping[str, Any] | str | os.PathLike[str] | None = None,
    *,
    rate_hz: float | None = None,
    resample_hz: float | None = None,
    decimal: Decimal | None = None,
    table: bool | None = None,
) -> Opened:
    """Return a file whose channels can be read in parts; arguments and refusals are those of `load`."""
    where = str(path)
    chart = None if channels is None else read_map(channels)
    contents = read_contents(path, decimal or (chart.decimal if chart else None))
    if chart is None:
        picked = all_channels(where, contents, rate_hz)
        columns = {name: Channel(column=line.name, crosstalk={}) for name, line in picked.items()}
        chart = ChannelMap(channels=columns)
    else:
        picked = {name: find_channel(where, contents, each.column) for name, each in chart.channels.items()}
    rows = {name: line.samples.size for name, line in picked.items()}
    if len(set(rows.values())) > 1:
        raise must_be(f"{where}: samples of channels", rows, "equal")
    short = max(rows.values()) <= TABLE_ROWS and all(line.times is None for line in picked.values())
    done: list[Finding] = []
    resample_hz, rate_hz = resample_hz or chart.resample_hz, rate_hz or chart.rate_hz
    if table:
        sampling = Sampling(rate_hz, "rows of a table")
    else:
        sampling = sampling_of(where, [*picked.values()], rate_hz)
    is_table = ((sampling.rate_hz is None or short) and resample_hz is None) if table is None else table
    if not is_table and resample_hz is not None:
        picked, how = resampled(where, picked, chart, resample_hz)
        done, sampling = [how], Sampling(resample_hz, "resample_hz")
    elif not is_table:
        _refuse_uneven(where, sampling)
    rate_hz = None if is_table else float(sampling.rate_hz or 0.0)
    return Opened(
        where, contents, picked, chart, channels is not None, rate_hz, sha256(path), sampling.source, tuple(done)
    )


def sha256(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file as hexadecimal text."""
    with open(Path(path), "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _refuse_uneven(where: str, sampling: Sampling) -> None:
    if sampling.rate_hz is None:
        raise must_be(f"{where}: rate_hz", None, "a number of Hz in the map, or times", "", "RATE-UNKNOWN")
    accepted = f"even, or resample_hz = {math.ceil(sampling.rate_hz)}"
    if sampling.gaps:
        lost, row = sum(count for _, count in sampling.gaps), sampling.gaps[0][0]
        raise must_be(f"{where}: times", f"{lost} samples missing, first after row {row}", accepted, "", "DATA-GAPS")
    if not sampling.even:
        raise must_be(f"{where}: times", "uneven", accepted, "", "TIMES-UNEVEN")


def all_channels(where: str, contents: found.Contents, rate_hz: float | None) -> dict[str, found.Channel]:
    """Return the channels that have as many samples, at one rate, as most samples are in."""
    signals = contents.signals() or contents.channels
    rates = samplings_of(where, signals, rate_hz)
    kinds = [(line.samples.size, rates[line.name].rate_hz or 0.0) for line in signals]
    usual = max(set(kinds), key=lambda kind: (kind[0] * kinds.count(kind), kind))
    return {line.name: line for line, kind in zip(signals, kinds, strict=True) if kind == usual}


def written(doubts: Iterable[Finding]) -> str:
    """Return findings as JSON, which the attributes of a recording and any file can hold."""
    return json.dumps([plain(each) for each in doubts])


def findings_of(attributes: Mapping[Any, Any]) -> list[Finding]:
    """Return what is in doubt of a recording, from its attributes."""
    return [Finding.from_dict(each) for each in json.loads(attributes.get("findings", "[]"))]


def load(
    path: str | os.PathLike[str],
    channels: ChannelMap | Mapping[str, Any] | str | os.PathLike[str] | None = None,
    *,
    rate_hz: float | None = None,
    resample_hz: float | None = None,
    decimal: Decimal | None = None,
    table: bool | None = None,
) -> xr.Dataset:
    """Return the channels of a file as one recording, all of it in memory (`opened` reads parts of a large one).

    Parameters
    ----------
    path : path
        File of any format that ``recordings.file_opening.read_contents`` knows.
    channels : mapping or path, optional
        What the file does not say: ``{"f_m": {"column": "Force", "scale": 0.25}}``, or a TOML file with the same under
        ``[channels.f_m]`` (`Channel` lists the fields). None takes every column under its own name.
    rate_hz : float, optional
        Sampling rate in Hz, where the file tells none or two.
    resample_hz : float, optional
        Rate in Hz to which samples at uneven times are brought, by straight lines (`resampled`); None refuses such a
        file. A finding says so.
    decimal : str, optional
        Decimal mark of a text, where its numbers can be read in two ways.
    table : bool, optional
        Whether the rows are samples in time (False) or separate measurements such as one line per weight (True). None:
        a table if nothing tells a rate, or if at most 64 rows come without times.

    Returns
    -------
    xarray.Dataset
        Variables with ``units`` over ``time`` in s, or over ``row`` for a table; attributes ``file``, ``sha256``,
        ``date``, ``rate_from``, and ``findings`` (`findings_of`): channels left out, units that nothing tells.

    Raises
    ------
    FrictionloopError
        In one line: the file or the map cannot be read; a channel of the map is not in the file (near names are
        listed); two rates disagree; times have gaps; channels have unequal lengths; a sample is NaN.
    """
    return opened(path, channels, rate_hz=rate_hz, resample_hz=resample_hz, decimal=decimal, table=table).whole()


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
    first, stop = max(runs_of(quiet), key=lambda pair: pair[1] - pair[0])
    return first * piece, stop * piece


def _parts(file: Opened, rows: int) -> Iterator[xr.Dataset]:
    for first in range(0, file.rows, rows):
        yield file.part(first, min(first + rows, file.rows))
