"""What is in a file, before anything is computed from it: shapes, rates, clipping, wraps, lost samples."""

from __future__ import annotations

import math
import os
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionloop.identification.sampling import Sampling, sampling_of
from frictionloop.recordings.contents import Channel, Contents
from frictionloop.recordings.whole import read_contents

FLAT_RUN = 4
"""Equal samples in a row at an end of the range that count as clipped (assumed: noise makes three)."""
LEVELS = 32
"""A channel with fewer different values is one of steps, such as masses, and does not clip (assumed)."""


class ChannelPreview(NamedTuple):
    """One channel at a glance."""

    name: str
    unit: str
    samples: int
    type: str
    least: float
    most: float
    rms: float
    """About its mean."""
    clipped: float
    """Share of the samples that stand at an end of the range in runs."""
    wraps: int
    """Jumps of a counter that starts again."""
    missing: int
    """Samples that are no finite number."""


class Preview(NamedTuple):
    """A file at a glance."""

    path: str
    channels: tuple[ChannelPreview, ...]
    sampling: Sampling
    notes: tuple[str, ...]
    date: str


def preview(path: str | os.PathLike[str], rate_hz: float | None = None) -> Preview:
    """Return what a file holds.

    Parameters
    ----------
    path : path
        File of any known format.
    rate_hz : float, optional
        Sampling rate in Hz, where the file tells none or two.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, or one that tells two rates.
    """
    contents = read_contents(path)
    sampling = sampling_of(str(path), contents, rate_hz)
    return Preview(
        str(path), tuple(map(_glance, contents.channels)), sampling, _warnings(contents, sampling), contents.date
    )


def _glance(line: Channel) -> ChannelPreview:
    values = line.samples
    real = np.abs(values) if values.dtype.kind == "c" else np.asarray(values, dtype=float)
    fine = real[np.isfinite(real)]
    if not fine.size:
        fine = np.zeros(1)
    wraps = _wraps(fine)
    return ChannelPreview(
        name=line.name,
        unit=line.unit or "",
        samples=real.size,
        type="complex" if values.dtype.kind == "c" else str(values.dtype),
        least=float(fine.min()),
        most=float(fine.max()),
        rms=float(fine.std()),
        clipped=0.0 if wraps else clipped_share(fine, line.full_scale),  # a counter that stands still
        wraps=wraps,
        missing=int(real.size - np.count_nonzero(np.isfinite(real))),
    )


def clipped(values: NDArray[np.float64], full_scale: float | None = None) -> NDArray[np.bool_]:
    """Return which samples stand at the largest or the least value in runs of four or more.

    An end where a signal merely turns has more samples just inside it than at it; at one where it clips it is the other
    way round. A channel of few levels does not clip, nor does one at the value at which it rests.
    """
    at = np.zeros(values.size, dtype=bool)
    span = float(np.ptp(values)) if values.size else 0.0
    if span == 0 or np.unique(values[:: max(values.size // 20000, 1)]).size < LEVELS:
        return at
    middle = float(np.median(values))
    for end in (float(values.max()), float(values.min())):
        if abs(end - middle) < 0.1 * span:
            continue  # where the channel rests
        near = np.abs(values - end) <= 1e-9 * span
        inside = np.abs(values - end) <= 0.01 * span
        edges = np.flatnonzero(np.diff(np.concatenate([[0], near.astype(np.int8), [0]])))
        runs = edges.reshape(-1, 2)
        long = runs[runs[:, 1] - runs[:, 0] >= FLAT_RUN]
        there = int(np.sum(long[:, 1] - long[:, 0]))
        if there and (
            2 * there >= np.count_nonzero(inside) or (full_scale and math.isclose(abs(end), full_scale, rel_tol=1e-3))
        ):
            for first, stop in long:
                at[first:stop] = True
    return at


def clipped_share(values: NDArray[np.float64], full_scale: float | None = None) -> float:
    """Return the share of samples that are clipped."""
    return float(np.mean(clipped(values, full_scale))) if values.size else 0.0


def _wraps(values: NDArray[np.float64]) -> int:
    """Return how often a counter starts again: jumps over most of the range between steps that are small."""
    span = float(np.ptp(values))
    if span < 128 or not np.array_equal(values[:1000], np.rint(values[:1000])):
        return 0
    steps = np.abs(np.diff(values))
    jumps = steps > 0.5 * span
    calm = steps[~jumps]
    return int(np.count_nonzero(jumps)) if calm.size and calm.max() < 0.05 * span else 0


def _warnings(contents: Contents, sampling: Sampling) -> tuple[str, ...]:
    said = list(contents.notes)
    if sampling.rate_hz is None:
        said.append("nothing tells a sampling rate: a plain table, or give rate_hz in the map")
    if sampling.gaps:
        lost = sum(count for _, count in sampling.gaps)
        row = sampling.gaps[0][0]
        said.append(f"{lost} samples are missing in {len(sampling.gaps)} gaps of the times, the first after row {row}")
    if not sampling.even:
        said.append("the times are uneven")
    sizes = {line.samples.size for line in contents.signals()}
    if len(sizes) > 1:
        said.append(f"channels have unequal lengths: {', '.join(map(str, sorted(sizes)))}")
    return tuple(said)
