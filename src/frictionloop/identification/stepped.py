"""A stepped sine that was recorded over time, as the table of its steps."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.identification.channels import channel, rate_of
from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]
LEAST = 8
"""Samples of a step that are needed."""


def stepped(recording: xr.Dataset) -> xr.Dataset:
    """Return a row for each step of the frequency: its amplitudes over the second half, when they have settled.

    Of a channel that goes to and fro the amplitude is that of a sine of the step's frequency, by least squares; of one
    that keeps its sign, as a lock-in's, the mean.

    Parameters
    ----------
    recording : xarray.Dataset
        ``frequency`` in Hz, which stays the same during a step, and other channels, over ``time`` in s.

    Raises
    ------
    FrictionloopError
        For a frequency that is none, steps of fewer than sixteen samples, or a rate too low for what goes to and fro.
    """
    frequency, rate_hz = channel(recording, "frequency", ("Hz",)), rate_of(recording)
    edges = np.concatenate([[0], np.flatnonzero(np.diff(frequency)) + 1, [frequency.size]])
    halves = [(a + (b - a) // 2, b) for a, b in pairwise(edges.tolist()) if b - a >= 2 * LEAST]
    if 2 * len(halves) < edges.size:
        raise FrictionloopError(
            f"recording: 'frequency' changes {edges.size - 2} times in {frequency.size} samples: must stay the same "
            f"for {2 * LEAST} samples at least, a step after the other"
        )
    steps = np.array([frequency[b - 1] for _, b in halves])
    rows = {"frequency": ("row", steps, recording["frequency"].attrs)}
    for name in map(str, recording.data_vars):
        if name != "frequency":
            values = np.asarray(recording[name].values, dtype=float)
            found = np.array(
                [_amplitude(name, values[a:b], f / rate_hz) for (a, b), f in zip(halves, steps, strict=True)]
            )
            rows[name] = ("row", found, recording[name].attrs)
    seconds = np.diff(edges).min() / rate_hz
    said = f"{steps.size} steps of {seconds:.3g} s or more: amplitudes are those of the second half of each"
    return xr.Dataset(rows, attrs=recording.attrs | {"told": f"{recording.attrs.get('told', '')}\n{said}".strip()})


def _amplitude(name: str, values: Array, periods: float) -> float:
    """Return the amplitude of a channel during a step; ``periods`` in a sample."""
    if abs(values.mean()) > values.std():
        return float(abs(values.mean()))
    if periods > 0.45:
        raise FrictionloopError(
            f"recording: {name!r} goes to and fro, with fewer than 2.2 samples in a period: must be sampled faster, or "
            "be an amplitude"
        )
    angle = 2 * np.pi * periods * np.arange(values.size)
    columns = np.column_stack([np.cos(angle), np.sin(angle), np.ones(values.size)])
    weight = np.linalg.lstsq(columns, values, rcond=None)[0]
    return float(np.hypot(weight[0], weight[1]))
