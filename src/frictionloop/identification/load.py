"""A file as a recording: channels named, in their units, over time, or a plain table over rows."""

from __future__ import annotations

import difflib
import hashlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import shift

from frictionloop.identification.channel_map import USUAL, Channel, ChannelMap, read_map
from frictionloop.identification.sampling import Sampling, sampling_of
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.units import UNITS, known_unit
from frictionloop.recordings import contents as found
from frictionloop.recordings.whole import read_contents

Array = NDArray[np.float64]
TABLE_ROWS = 64
"""A file of at most so many rows that has no column of times is a table (assumed)."""
SHOWN = 12


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
        _all(contents)
        if chart is None
        else {name: _find(where, contents, each) for name, each in chart.channels.items()}
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
        name: _variable(
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
        "told": "\n".join([*_left_out(contents, picked, channels is not None), *_assumed(picked, chart, data)]),
    }
    if is_table:
        return xr.Dataset(data, attrs=attributes)
    time = xr.Variable("time", np.arange(max(rows.values())) / rate, {"units": "s"})
    return xr.Dataset(data, {"time": time}, attributes)


def sha256(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file as hexadecimal text."""
    with open(Path(path), "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _all(contents: found.Contents) -> dict[str, found.Channel]:
    """Return the channels that have as many samples as most samples are in."""
    signals = contents.signals() or contents.channels
    sizes = [line.samples.size for line in signals]
    usual = max(set(sizes), key=lambda size: (size * sizes.count(size), size))
    return {line.name: line for line in signals if line.samples.size == usual}


def _left_out(contents: found.Contents, picked: Mapping[str, found.Channel], mapped: bool) -> list[str]:
    """Return what is said of channels that no map chose and that have another length than most."""
    taken = {line.name for line in picked.values()}
    other = [line for line in contents.signals() if line.name not in taken]
    return [] if mapped else [f"{line.name}: left out, of {line.samples.size} samples" for line in other]


def _assumed(picked: Mapping[str, found.Channel], chart: ChannelMap, data: Mapping[str, xr.Variable]) -> list[str]:
    """Return what is said of channels whose unit neither file nor map tells."""
    silent = [name for name, line in picked.items() if not _tells_unit(line, chart.channels[name])]
    units = {name: data[name].attrs["units"] for name in silent}
    return [f"{name}: nothing tells its unit; taken for {unit}" for name, unit in units.items() if unit]


def _tells_unit(line: found.Channel, told: Channel) -> bool:
    return bool(line.unit or told.unit or told.gives or told.scale is not None)


def _find(where: str, contents: found.Contents, wanted: Channel) -> found.Channel:
    names = [line.name for line in contents.channels]
    if isinstance(wanted.column, int):
        if 0 <= wanted.column < len(names):
            return contents.channels[wanted.column]
        raise FrictionloopError(f"{where}: column = {wanted.column} is not there; accepted: 0 to {len(names) - 1}")
    exact = [line for line in contents.channels if line.name == wanted.column]
    loose = [
        line for line in contents.channels if line.name.rpartition("/")[2].lower() == wanted.column.strip().lower()
    ]
    for candidates in (exact, loose):
        if len(candidates) == 1:
            return candidates[0]
    lines = [name for name in names if name.partition("[")[0] == wanted.column.strip()]
    if lines:
        raise FrictionloopError(
            f"{where}: column = {wanted.column!r} has {len(lines)} lines; accepted: one of them, {lines[0]!r} to "
            f"{lines[-1]!r}, or in a project file {lines[0].replace('0', '*', 1)!r} for all"
        )
    near = difflib.get_close_matches(wanted.column, names, n=3, cutoff=0.4)
    hint = f"; did you mean {' or '.join(map(repr, near))}?" if near else ";"
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    raise FrictionloopError(
        f"{where}: column = {wanted.column!r} is not there{hint} accepted: {', '.join(map(repr, names[:SHOWN]))}{more}"
    )


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


def _variable(
    where: str, name: str, line: found.Channel, told: Channel, rate_hz: float, dim: str, mapped: bool
) -> xr.Variable:
    if line.samples.dtype.kind == "c":
        raise FrictionloopError(
            f"{where}: column {line.name!r} is complex, a response over frequency; accepted: samples"
        )
    values = np.asarray(line.samples, dtype=float)
    if mapped:
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise FrictionloopError(
                f"{where}: column {line.name!r} is {values[bad[0]]} at row {bad[0]} and {bad.size - 1} more; "
                "accepted: numbers"
            )
        if values.size > 1 and np.ptp(values) == 0:
            raise FrictionloopError(f"{where}: column {line.name!r} is {values[0]:g} throughout; is it the right one?")
    if told.wrap is not None:
        values = np.unwrap(values, period=told.wrap)
    if told.zero_s is not None:
        values = values - _zero(where, name, values, told.zero_s, rate_hz)
    factor, unit = _factor(where, name, line, told, mapped)
    values = (told.sign or 1) * factor * values
    if told.delay_s:
        values = shift(values, -told.delay_s * rate_hz, order=3, mode="nearest")
    return xr.Variable(dim, values, {"units": unit, "long_name": line.name})


def _zero(where: str, name: str, values: Array, window: tuple[float, float], rate_hz: float) -> float:
    first, stop = round(window[0] * rate_hz), round(window[1] * rate_hz)
    if not 0 <= first < stop <= values.size:
        raise FrictionloopError(
            f"{where}: channels.{name}.zero_s = {window[0]:g} to {window[1]:g} s holds no samples; accepted: within 0 "
            f"to {values.size / rate_hz:g}"
        )
    return float(values[first:stop].mean())


def _factor(where: str, name: str, line: found.Channel, told: Channel, mapped: bool) -> tuple[float, str]:
    """Return what a column is multiplied by, and the unit that this gives."""
    stated = told.unit or line.unit
    base = UNITS.get(known_unit(stated or "") or "")
    if told.scale is not None:
        return told.scale, told.gives or USUAL.get(name, "N")
    if base is not None:
        if told.gives is not None and told.gives != base[0]:
            raise FrictionloopError(
                f"{where}: channels.{name}: {stated} is no {told.gives}; accepted: a scale in {told.gives}/{stated}"
            )
        return base[1], base[0]
    if told.gives is not None or not mapped:
        return 1.0, told.gives or stated or ""
    # A channel of which nothing is said is in the unit of its kind; counts and the like are kept as they are.
    return 1.0, stated or USUAL.get(name, "N")
