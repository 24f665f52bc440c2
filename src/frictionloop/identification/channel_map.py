"""What a file does not say of its channels, which is which, in what unit, which way round, and columns so read."""

from __future__ import annotations

import difflib
import os
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydantic import Field
from scipy.ndimage import shift

from frictionloop.findings import Finding
from frictionloop.parameters.block import Block, Number, Positive, Whole
from frictionloop.parameters.description import Description
from frictionloop.parameters.toml_files import read_tree
from frictionloop.quantities import check_known, must_be
from frictionloop.quantities.timestamp_jitter import MISSING
from frictionloop.quantities.units import UNITS, known_unit
from frictionloop.recordings import contents as found
from frictionloop.recordings.clock import may_be_seconds
from frictionloop.recordings.headers import header
from frictionloop.recordings.stored import Samples
from frictionloop.recordings.straight_lines import even_times, mean_rate, tells_seconds

SHOWN = 12
"""Channels that an error lists."""

Array = NDArray[np.float64]
Window = tuple[Number, Number]
USUAL = {"mass": "kg", "frequency": "Hz", "vibration": "um", "envelope": "um", "amplitude": "um", "a": "um"}
USUAL |= {"drive": "", "jump": "V", "answer": "V", "minutes": "min", "temperature": "degC"}
USUAL |= {"position": "m", "speed": "m/s"}
"""Unit of a channel of which nothing is said, by its name; of the others it is N."""


class Channel(Block):
    """One channel: value = sign * scale * (column - its mean over ``zero_s``), after wraps are undone."""

    column: str | Whole = 0
    """Name in the file, as ``frictionloop identify channels`` lists it, or its number from 0.

    In a project file ``name[:, *]`` takes every line of an array, and ``name{*}`` every cell, each as a recording of
    its own; of weights each is what the sensor read under one of the masses."""
    unit: str | None = None
    """Unit of the column, where the file says none or a wrong one: N, mN, V, mV, kg, g, m, mm, m/s, mm/s, counts."""
    scale: Annotated[Number, Field(description="One column unit, in ``gives``.")] | None = None
    gives: str | None = None
    """Unit after ``scale``: N, V, kg, m, um, Hz or counts; left out, what a channel of that name usually has: kg for
    mass, m for position, um for vibration, N for forces."""
    newtons_per_unit: Number | None = None
    """What one unit is in N by an earlier calibration; it counts only where the project has no weights."""
    sign: Annotated[Whole, Field(ge=-1, le=1)] = 1
    """-1 turns the channel round."""
    zero_s: Window | None = None
    """From when to when, in s after the first sample, nothing acted: the mean over it is taken off. Rows of a table
    count as seconds."""
    wrap: Positive | None = None
    """Where a counter starts again from 0, in the column's unit."""
    crosstalk: Annotated[dict[str, Number], Field(default_factory=dict)]
    """What the channel reads of others, by their names: ``{ load = 0.02 }`` takes 0.02 times the load off, after
    scales."""
    delay_s: Number = 0.0
    """How much later than the others the channel was recorded, in s: it is moved forward by this."""


class ChannelMap(Description):
    """The channels of a file by the names that the analyses know: ``f_m``, ``hammer``, ``mass``, ``load`` ..."""

    rate_hz: Positive | None = None
    """Sampling rate in Hz, where the file tells none or two."""
    resample_hz: Positive | None = None
    """Rate in Hz to which channels at uneven times are brought, by straight lines between their samples."""
    channels: dict[str, Channel]
    """By name."""


def read_map(source: ChannelMap | Mapping[str, Any] | str | os.PathLike[str]) -> ChannelMap:
    """Return a channel map from itself, from ``{name: {"column": ...}}`` or ``{name: column}``, or from a TOML file.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, or a field that is unknown or out of range.
    """
    if isinstance(source, ChannelMap):
        return source
    if isinstance(source, Mapping):
        tree = {
            name: entry if isinstance(entry, (Mapping, Channel)) else {"column": entry}
            for name, entry in source.items()
        }
        return ChannelMap.from_tree({"channels": tree}, "channels: ")
    return ChannelMap.from_tree(read_tree(source), f"{source}: ")


class Place(NamedTuple):
    """Where the rows stand that a column is asked for, and how they are taken."""

    first: int
    stop: int
    rate_hz: float
    dim: str
    mapped: bool
    """Whether a map names the column: then it must hold numbers that are not all alike."""


def variable(where: str, name: str, line: found.Channel, told: Channel, place: Place) -> xr.Variable:
    """Return rows of a column unwrapped, less its zero, scaled, turned and moved as the map says."""
    if line.samples.dtype.kind == "c":
        raise must_be(f"{where}: column {line.name!r}", "complex", "samples in time")
    values = np.asarray(line.samples[place.first : place.stop], dtype=float)
    if place.mapped:
        _refuse_no_numbers(where, line, values, place)
    if told.wrap is not None:
        values = np.unwrap(values, period=told.wrap)
    if told.zero_s is not None:
        values = values - _zero(where, name, line.samples, told, place.rate_hz)
    factor, unit = _factor(where, name, line, told, place.mapped)
    values = (told.sign or 1) * factor * values
    if told.delay_s:
        values = shift(values, -told.delay_s * place.rate_hz, order=3, mode="nearest")
    attributes: dict[str, object] = {"units": unit, "long_name": line.name}
    if told.newtons_per_unit is not None:
        attributes["newtons_per_unit"] = told.newtons_per_unit
    return xr.Variable(place.dim, values, attributes)


def _refuse_no_numbers(where: str, line: found.Channel, values: Array, place: Place) -> None:
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        row = place.first + int(bad[0])
        accepted = f"a number; {bad.size} are none"
        raise must_be(f"{where}: column {line.name!r} at row {row}", float(values[bad[0]]), accepted, "", "DATA-GAPS")
    if line.samples.size == values.size > 1 and np.ptp(values) == 0:
        raise must_be(f"{where}: column {line.name!r}", f"{values[0]:g} throughout", "one that varies")


def _zero(where: str, name: str, samples: Samples, told: Channel, rate_hz: float) -> float:
    window = told.zero_s or (0.0, 0.0)
    first, stop = round(window[0] * rate_hz), round(window[1] * rate_hz)
    if not 0 <= first < stop <= samples.size:
        accepted = f"rising within 0 to {samples.size / rate_hz:g}"
        raise must_be(f"{where}: channels.{name}.zero_s", window, accepted, "s")
    values = np.asarray(samples[first:stop], dtype=float)
    return float(values.mean() if told.wrap is None else np.unwrap(values, period=told.wrap).mean())


def _factor(where: str, name: str, line: found.Channel, told: Channel, mapped: bool) -> tuple[float, str]:
    """Return what a column is multiplied by, and the unit that this gives."""
    stated = told.unit or line.unit
    base = UNITS.get(known_unit(stated or "") or "")
    if told.scale is not None:
        return told.scale, told.gives or USUAL.get(name, "N")
    if base is not None:
        if told.gives is not None and told.gives != base[0]:
            raise must_be(f"{where}: channels.{name}.gives", told.gives, f"{base[0]}, or with a scale")
        return base[1], base[0]
    if told.gives is not None or not mapped:
        return 1.0, told.gives or stated or ""
    # A channel of which nothing is said is in the unit of its kind; counts and the like are kept as they are.
    return 1.0, stated or USUAL.get(name, "N")


def resampled(
    where: str,
    contents: found.Contents,
    picked: Mapping[str, found.Channel],
    chart: ChannelMap | None,
    resample_hz: float,
) -> tuple[dict[str, found.Channel], Finding]:
    """Return channels at even times, as `recordings.straight_lines` has them, and what was done.

    A counter is unwrapped first.
    """
    times = _times(where, contents, resample_hz)
    even = even_times(where, times, resample_hz)
    lines: dict[str, found.Channel] = {}
    for name, line in picked.items():
        values = np.asarray(line.samples[: line.samples.size], dtype=float)
        if values.size != times.size:
            raise must_be(f"{where}: samples of {line.name!r}", int(values.size), f"{times.size}, as the times")
        wrap = None if chart is None else chart.channels[name].wrap
        values = values if wrap is None else np.unwrap(values, period=wrap)
        lines[name] = replace(line, samples=np.interp(even, times, values))
    apart_ms = 1e3 * np.diff(times)
    gaps = int(np.count_nonzero(apart_ms > MISSING * np.median(apart_ms)))
    more = {
        "gaps": gaps,
        "samples": times.size,
        "least_apart_ms": float(apart_ms.min()),
        "most_apart_ms": float(apart_ms.max()),
    }
    return lines, Finding("RESAMPLED", value=resample_hz, unit="Hz", limit=mean_rate(times) / 10, more=more)


def _times(where: str, contents: found.Contents, resample_hz: float) -> Array:
    """Return the times of a file in s."""
    clock = contents.clock()
    if clock is None or clock.samples.size < 3:
        raise must_be(f"{where}: column of times", None, "resample_hz needs it")
    values = np.asarray(clock.samples[: clock.samples.size], dtype=float)
    seconds = may_be_seconds(float(np.median(np.diff(values)))) or tells_seconds(values, resample_hz)
    unit, factor = UNITS.get(str(clock.unit), ("s" if seconds else "", 1.0))
    if unit != "s":
        raise must_be(f"{where}: unit of {clock.name!r}", clock.unit, "told by its name, as 'time_s'")
    return factor * values


def find_channel(where: str, contents: found.Contents, wanted: Channel) -> found.Channel:
    """Return the channel that a map names: by its path, its last part, as its header spells it, or by its number."""
    names = [line.name for line in contents.channels]
    if isinstance(wanted.column, int):
        if 0 <= wanted.column < len(names):
            return contents.channels[wanted.column]
        raise must_be(f"{where}: column", wanted.column, f"from 0 to {len(names) - 1}")
    exact = [line for line in contents.channels if line.name == wanted.column]
    loose = [
        line for line in contents.channels if line.name.rpartition("/")[2].lower() == wanted.column.strip().lower()
    ]
    said = header(wanted.column)
    spelt = [line for line in contents.channels if said.unit and (line.name, line.unit) == (said.name, said.unit)]
    for candidates in (exact, loose, spelt):
        if len(candidates) == 1:
            return candidates[0]
    lines = [name for name in names if name.partition("[")[0] == wanted.column.strip()]
    if lines:
        every = lines[0].replace("0", "*", 1)
        raise must_be(f"{where}: column", wanted.column, f"{lines[0]!r} to {lines[-1]!r}, or {every!r} for all")
    near = difflib.get_close_matches(wanted.column, names, n=SHOWN, cutoff=0.2) or names
    check_known(f"{where}: column", [wanted.column], names if len(names) <= SHOWN else near[:SHOWN])
    raise must_be(f"{where}: column", wanted.column, "a number: it stands twice")
