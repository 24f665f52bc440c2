"""Samples at uneven times brought to even ones, where a map asks for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from frictionloop.identification.channel_map import ChannelMap
from frictionloop.identification.sampling import UNEVEN
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.units import UNITS
from frictionloop.recordings.clock import may_be_seconds
from frictionloop.recordings.contents import Channel, Contents

Array = NDArray[np.float64]
LONGEST_STEP = 10.0
"""A longer time without samples, in usual steps, is a hole that no straight line fills (assumed)."""


def resampled(
    where: str, contents: Contents, picked: Mapping[str, Channel], chart: ChannelMap | None, resample_hz: float
) -> tuple[dict[str, Channel], str]:
    """Return channels at even times, by straight lines between their samples, and in words what was done.

        t_k = t_0 + k/f,   y(t_k) = y_i + (y_(i+1) - y_i) (t_k - t_i)/(t_(i+1) - t_i)

    A sine of frequency f_y between samples that are T apart loses up to (pi f_y T)^2/2 of its height. A counter is
    unwrapped first.

    Parameters
    ----------
    where : str
        Named in errors.
    contents, picked, chart
        The file, the channels that are taken from it, and the map, which tells where counters wrap.
    resample_hz : float
        Rate in Hz, at least the mean rate of the samples: a lower one would fold what lies above half of it.

    Raises
    ------
    FrictionloopError
        For a file without times, times that do not rise, a rate too low, or a time without samples of more than ten
        usual steps.
    """
    times = _times(where, contents)
    steps = np.diff(times)
    usual = float(np.median(steps))
    mean_hz = steps.size / float(times[-1] - times[0])
    if resample_hz < (1 - 1e-3) * mean_hz:
        raise FrictionloopError(
            f"{where}: resample_hz = {resample_hz:g}: must be at least {mean_hz:.4g}, the mean rate of the samples"
        )
    longest = int(np.argmax(steps))
    if steps[longest] > LONGEST_STEP * usual:
        raise FrictionloopError(
            f"{where}: no samples for {steps[longest]:.3g} s after row {longest}: resample_hz fills at most "
            f"{LONGEST_STEP * usual:.3g} s, ten usual steps; accepted: a part without such a hole"
        )
    even = times[0] + np.arange(int((times[-1] - times[0]) * resample_hz * (1 + 1e-12)) + 1) / resample_hz
    lines: dict[str, Channel] = {}
    for name, line in picked.items():
        values = np.asarray(line.samples[: line.samples.size], dtype=float)
        if values.size != times.size:
            raise FrictionloopError(
                f"{where}: {line.name!r} has {values.size} samples and the times {times.size}; accepted: as many"
            )
        wrap = None if chart is None else chart.channels[name].wrap
        values = values if wrap is None else np.unwrap(values, period=wrap)
        lines[name] = replace(line, samples=np.interp(even, times, values))
    bridged = int(np.count_nonzero(steps > (2 - UNEVEN) * usual))
    over = f", over {bridged} gaps of up to {1e3 * steps[longest]:.3g} ms" if bridged else ""
    said = (
        f"uneven times: {times.size} samples, {1e3 * steps.min():.3g} to {1e3 * steps.max():.3g} ms apart, were "
        f"brought to {resample_hz:g} Hz by straight lines between them{over}; that lowers a sine of "
        f"{mean_hz / 10:.3g} Hz by up to 5 %, and a faster one by more"
    )
    return lines, said


def _times(where: str, contents: Contents) -> Array:
    """Return the times of a file in s, which must rise."""
    clock = contents.clock()
    if clock is None or clock.samples.size < 3:
        raise FrictionloopError(f"{where}: resample_hz: there is no column of times; accepted: a file that has one")
    values = np.asarray(clock.samples[: clock.samples.size], dtype=float)
    unit, factor = UNITS.get(str(clock.unit), ("s" if may_be_seconds(float(np.median(np.diff(values)))) else "", 1.0))
    if unit != "s":
        raise FrictionloopError(
            f"{where}: resample_hz: nothing tells the unit of {clock.name!r}; accepted: a name such as 'time_s' or "
            "'time [ms]'"
        )
    times = factor * values
    bad = np.flatnonzero(~(np.diff(times) > 0))
    if bad.size:
        row = int(bad[0]) + 1
        raise FrictionloopError(f"{where}: resample_hz: the times do not rise at row {row}; accepted: times that do")
    return times
