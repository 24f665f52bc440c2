"""A file as a recording: channels named, in their units, over time, or a plain table over rows."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.identification.channel_map import Channel, ChannelMap, read_map
from frictionloop.identification.picked import all_channels, assumed_units, find_channel, left_out
from frictionloop.identification.sampling import Sampling, sampling_of
from frictionloop.identification.scaled import variable
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings import contents as found
from frictionloop.recordings.whole import read_contents

TABLE_ROWS = 64
"""A file of at most so many rows that has no column of times is a table (assumed)."""


def load(
    path: str | os.PathLike[str],
    channels: ChannelMap | Mapping[str, Any] | str | os.PathLike[str] | None = None,
    *,
    rate_hz: float | None = None,
    table: bool | None = None,
) -> xr.Dataset:
    """Return the channels of a file as one recording.

    Parameters
    ----------
    path : path
        File of any format that ``recordings.whole.read_contents`` knows.
    channels : mapping or path, optional
        What the file does not say: ``{"f_m": {"column": "Force", "scale": 0.25}}``, or a TOML file with the same under
        ``[channels.f_m]`` (`Channel` lists the fields). None takes every column under its own name.
    rate_hz : float, optional
        Sampling rate in Hz, where the file tells none or two.
    table : bool, optional
        Whether the rows are samples in time (False) or separate measurements such as one line per weight (True). None:
        a table if nothing tells a rate, or if at most 64 rows come without times.

    Returns
    -------
    xarray.Dataset
        Variables with ``units`` over ``time`` in s, or over ``row`` for a table; attributes ``file``, ``sha256``,
        ``date``, ``rate_from``, and ``told``, a line for each channel left out and each unit that nothing tells.

    Raises
    ------
    FrictionloopError
        In one line: the file or the map cannot be read; a channel of the map is not in the file (near names are
        listed); two rates disagree; times have gaps; channels have unequal lengths; a sample is NaN.
    """
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
    is_table = (sampling.rate_hz is None or short) if table is None else table
    if not is_table:
        _refuse_uneven(where, sampling, contents)
    rate = 1.0 if is_table else float(sampling.rate_hz or 0.0)
    chart = chart or ChannelMap(channels={name: Channel(column=line.name) for name, line in picked.items()})
    data = {
        name: variable(
            where, name, line, chart.channels[name], rate, "row" if is_table else "time", channels is not None
        )
        for name, line in picked.items()
    }
    attributes = {
        "source": "recorded",
        "file": where,
        "sha256": sha256(path),
        "date": contents.date,
        "rate_from": sampling.source,
        "told": "\n".join([*left_out(contents, picked, channels is not None), *assumed_units(picked, chart, data)]),
    }
    if is_table:
        return xr.Dataset(data, attrs=attributes)
    time = xr.Variable("time", np.arange(max(rows.values())) / rate, {"units": "s"})
    return xr.Dataset(data, {"time": time}, attributes)


def sha256(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file as hexadecimal text."""
    with open(Path(path), "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _refuse_uneven(where: str, sampling: Sampling, contents: found.Contents) -> None:
    if sampling.rate_hz is None:
        raise FrictionloopError(
            f"{where}: the sampling rate is told nowhere; accepted: rate_hz in the map, or a column of times"
        )
    if sampling.gaps:
        row, missing = sampling.gaps[0]
        lost = sum(count for _, count in sampling.gaps)
        raise FrictionloopError(
            f"{where}: {lost} samples are missing in {len(sampling.gaps)} gaps of the times, {missing} of them after "
            f"row {row}; accepted: a recording without gaps"
        )
    if not sampling.even:
        raise FrictionloopError(
            f"{where}: the times are uneven; accepted: equal steps, as a recorder's clock makes them"
        )
