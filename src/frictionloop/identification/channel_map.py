"""What a file does not say of its channels: which is which, in what unit, how much, which way round."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field

from frictionloop.parameters.block import Block, Number, Positive, Whole
from frictionloop.parameters.description import Description
from frictionloop.parameters.files import read_tree

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
    scale: Annotated[Number, Field(description="What one of the column's unit is, in ``gives``.")] | None = None
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
