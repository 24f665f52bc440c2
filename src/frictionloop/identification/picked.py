"""Which channels of a file a map picks, and what is said of the others."""

from __future__ import annotations

import difflib
from collections.abc import Mapping

import xarray as xr

from frictionloop.identification.channel_map import Channel, ChannelMap
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings import contents as found
from frictionloop.recordings.headers import header

SHOWN = 12


def all_channels(contents: found.Contents) -> dict[str, found.Channel]:
    """Return the channels that have as many samples as most samples are in."""
    signals = contents.signals() or contents.channels
    sizes = [line.samples.size for line in signals]
    usual = max(set(sizes), key=lambda size: (size * sizes.count(size), size))
    return {line.name: line for line in signals if line.samples.size == usual}


def left_out(contents: found.Contents, picked: Mapping[str, found.Channel], mapped: bool) -> list[str]:
    """Return what is said of channels that no map chose and that have another length than most."""
    taken = {line.name for line in picked.values()}
    other = [line for line in contents.signals() if line.name not in taken]
    return [] if mapped else [f"{line.name}: left out, of {line.samples.size} samples" for line in other]


def assumed_units(picked: Mapping[str, found.Channel], chart: ChannelMap, data: Mapping[str, xr.Variable]) -> list[str]:
    """Return what is said of channels whose unit neither file nor map tells."""
    silent = [name for name, line in picked.items() if not _tells_unit(line, chart.channels[name])]
    units = {name: data[name].attrs["units"] for name in silent}
    return [f"{name}: nothing tells its unit; taken for {unit}" for name, unit in units.items() if unit]


def _tells_unit(line: found.Channel, told: Channel) -> bool:
    return bool(line.unit or told.unit or told.gives or told.scale is not None)


def find_channel(where: str, contents: found.Contents, wanted: Channel) -> found.Channel:
    """Return the channel that a map names: by its path, its last part, as its header spells it, or by its number."""
    names = [line.name for line in contents.channels]
    if isinstance(wanted.column, int):
        if 0 <= wanted.column < len(names):
            return contents.channels[wanted.column]
        raise FrictionloopError(f"{where}: column = {wanted.column} is not there; accepted: 0 to {len(names) - 1}")
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
