"""A file as a recording: channels named, in their units, over time, or a plain table over rows."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import xarray as xr

from frictionloop.identification.channel_map import ChannelMap
from frictionloop.identification.opened import opened


def load(
    path: str | os.PathLike[str],
    channels: ChannelMap | Mapping[str, Any] | str | os.PathLike[str] | None = None,
    *,
    rate_hz: float | None = None,
    resample_hz: float | None = None,
    table: bool | None = None,
) -> xr.Dataset:
    """Return the channels of a file as one recording, all of it in memory (`opened` reads parts of a large one).

    Parameters
    ----------
    path : path
        File of any format that ``recordings.whole.read_contents`` knows.
    channels : mapping or path, optional
        What the file does not say: ``{"f_m": {"column": "Force", "scale": 0.25}}``, or a TOML file with the same under
        ``[channels.f_m]`` (`Channel` lists the fields). None takes every column under its own name.
    rate_hz : float, optional
        Sampling rate in Hz, where the file tells none or two.
    resample_hz : float, optional
        Rate in Hz to which samples at uneven times are brought, by straight lines (`resampled`); None refuses such a
        file. ``told`` says what was done.
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
    file = opened(path, channels, rate_hz=rate_hz, resample_hz=resample_hz, table=table)
    return file.part(0, file.rows)
