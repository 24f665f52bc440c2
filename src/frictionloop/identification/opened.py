"""A file of channels that is open: it can be read as a whole, or from row to row."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.identification.channel_map import Channel, ChannelMap, read_map
from frictionloop.identification.picked import all_channels, assumed_units, find_channel, left_out
from frictionloop.identification.resampled import resampled
from frictionloop.identification.sampling import Sampling, sampling_of
from frictionloop.identification.scaled import Place, variable
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings import contents as found
from frictionloop.recordings.stored import Stored
from frictionloop.recordings.whole import read_contents

TABLE_ROWS = 64
"""A file of at most so many rows that has no column of times is a table (assumed)."""


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
    resampled: str = ""
    """What was done to uneven times, in words."""

    @property
    def rows(self) -> int:
        """Samples of a channel."""
        return max(line.samples.size for line in self.picked.values())

    @property
    def stored(self) -> bool:
        """Whether the samples are still in the file."""
        return any(isinstance(line.samples, Stored) for line in self.picked.values())

    def part(self, first: int, stop: int) -> xr.Dataset:
        """Return rows first to stop as a recording, as `load` returns all of them."""
        place = Place(first, stop, self.rate_hz or 1.0, "time" if self.rate_hz else "row", self.mapped)
        data = {
            name: variable(self.where, name, line, self.chart.channels[name], place)
            for name, line in self.picked.items()
        }
        data = {name: self._freed(name, data) for name in data}
        told = [
            *([self.resampled] if self.resampled else []),
            *left_out(self.contents, self.picked, self.mapped),
            *assumed_units(self.picked, self.chart, data),
        ]
        attributes = {
            "source": "recorded",
            "file": self.where,
            "sha256": self.sha256,
            "date": self.contents.date,
            "rate_from": self.rate_from,
            "told": "\n".join(told),
        }
        if not self.rate_hz:
            return xr.Dataset(data, attrs=attributes)
        samples = max(each.size for each in data.values())
        time = xr.Variable("time", (first + np.arange(samples)) / self.rate_hz, {"units": "s"})
        return xr.Dataset(data, {"time": time}, attributes)

    def _freed(self, name: str, data: Mapping[str, xr.Variable]) -> xr.Variable:
        """Return a channel less what it reads of the others."""
        found = data[name]
        for other, share in self.chart.channels[name].crosstalk.items():
            if other not in data or other == name:
                there = ", ".join(each for each in data if each != name) or "none"
                raise FrictionloopError(
                    f"{self.where}: channels.{name}.crosstalk: {other!r} is no other channel; accepted: {there}"
                )
            found = found.copy(data=found.values - share * data[other].values)
        return found


def opened(
    path: str | os.PathLike[str],
    channels: ChannelMap | Mapping[str, Any] | str | os.PathLike[str] | None = None,
    *,
    rate_hz: float | None = None,
    resample_hz: float | None = None,
    table: bool | None = None,
) -> Opened:
    """Return a file whose channels can be read in parts; arguments and refusals are those of `load`."""
    where = str(path)
    contents = read_contents(path)
    chart = None if channels is None else read_map(channels)
    sampling = sampling_of(where, contents, rate_hz or (chart.rate_hz if chart else None))
    picked = (
        all_channels(contents)
        if chart is None
        else {name: find_channel(where, contents, each) for name, each in chart.channels.items()}
    )
    rows = {name: line.samples.size for name, line in picked.items()}
    if chart is not None and len(set(rows.values())) > 1:
        sizes = ", ".join(f"{name!r} has {size}" for name, size in rows.items())
        raise FrictionloopError(f"{where}: channels have unequal lengths: {sizes} samples; accepted: equal ones")
    short = max(rows.values()) <= TABLE_ROWS and contents.clock() is None
    resample_hz, said = resample_hz or (chart.resample_hz if chart else None), ""
    is_table = ((sampling.rate_hz is None or short) and resample_hz is None) if table is None else table
    if not is_table and resample_hz is not None:
        picked, said = resampled(where, contents, picked, chart, resample_hz)
        sampling = Sampling(resample_hz, "resample_hz")
    elif not is_table:
        _refuse_uneven(where, sampling)
    rate = float(sampling.rate_hz or 0.0)
    chart = chart or ChannelMap(
        channels={name: Channel(column=line.name, crosstalk={}) for name, line in picked.items()}
    )
    rate_hz = None if is_table else rate
    return Opened(where, contents, picked, chart, channels is not None, rate_hz, sha256(path), sampling.source, said)


def sha256(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file as hexadecimal text."""
    with open(Path(path), "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _refuse_uneven(where: str, sampling: Sampling) -> None:
    if sampling.rate_hz is None:
        raise FrictionloopError(
            f"{where}: the sampling rate is told nowhere; accepted: rate_hz in the map, or a column of times"
        )
    if sampling.gaps:
        row, missing = sampling.gaps[0]
        lost = sum(count for _, count in sampling.gaps)
        raise FrictionloopError(
            f"{where}: {lost} samples are missing in {len(sampling.gaps)} gaps of the times, {missing} of them after "
            f"row {row}; accepted: a recording without gaps, or {_offer(sampling.rate_hz)}"
        )
    if not sampling.even:
        raise FrictionloopError(
            f"{where}: the times are uneven; accepted: equal steps, as a recorder's clock makes them, or "
            f"{_offer(sampling.rate_hz)}"
        )


def _offer(rate_hz: float) -> str:
    return (
        f"resample_hz = {math.ceil(rate_hz)} in the map or the project, which draws straight lines between the samples"
    )
