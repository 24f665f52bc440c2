"""Samples at uneven times brought to even ones, where a map asks for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from frictionloop.findings import Finding
from frictionloop.identification.channel_map import ChannelMap
from frictionloop.quantities import must_be
from frictionloop.quantities.steps import MISSING
from frictionloop.quantities.units import UNITS
from frictionloop.recordings.clock import may_be_seconds
from frictionloop.recordings.contents import Channel, Contents
from frictionloop.recordings.straight_lines import even_times, mean_rate, tells_seconds

Array = NDArray[np.float64]


def resampled(
    where: str, contents: Contents, picked: Mapping[str, Channel], chart: ChannelMap | None, resample_hz: float
) -> tuple[dict[str, Channel], Finding]:
    """Return channels at even times, as `recordings.straight_lines` has them, and what was done.

    A counter is unwrapped first.

    Parameters
    ----------
    where : str
        Named in errors.
    contents, picked, chart
        The file, the channels that are taken from it, and the map, which tells where counters wrap.
    resample_hz : float
        Rate in Hz, at least the mean rate of the samples.

    Raises
    ------
    FrictionloopError
        As `even_times`, and for a file without times.
    """
    times = _times(where, contents, resample_hz)
    even = even_times(where, times, resample_hz)
    lines: dict[str, Channel] = {}
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


def _times(where: str, contents: Contents, resample_hz: float) -> Array:
    """Return the times of a file in s."""
    clock = contents.clock()
    if clock is None or clock.samples.size < 3:
        raise must_be(f"{where}: column of times", None, "there for resample_hz")
    values = np.asarray(clock.samples[: clock.samples.size], dtype=float)
    seconds = may_be_seconds(float(np.median(np.diff(values)))) or tells_seconds(values, resample_hz)
    unit, factor = UNITS.get(str(clock.unit), ("s" if seconds else "", 1.0))
    if unit != "s":
        raise must_be(f"{where}: unit of {clock.name!r}", clock.unit, "told by a name such as 'time_s'")
    return factor * values
