"""What is in a file, before anything is computed from it: shapes, rates, clipping, wraps, lost samples."""

from __future__ import annotations

import os
from itertools import zip_longest
from typing import NamedTuple

from frictionloop.identification.glance import ChannelPreview, Glance
from frictionloop.identification.sampling import Sampling, sampling_of
from frictionloop.loop.progress import progress_bar
from frictionloop.recordings.contents import Channel, Contents
from frictionloop.recordings.stored import blocks_of, count_blocks
from frictionloop.recordings.whole import read_contents


class Preview(NamedTuple):
    """A file at a glance."""

    path: str
    channels: tuple[ChannelPreview, ...]
    sampling: Sampling
    notes: tuple[str, ...]
    date: str


def preview(path: str | os.PathLike[str], rate_hz: float | None = None, progress: bool | None = None) -> Preview:
    """Return what a file holds; of a large one every sample is looked at, block by block.

    Parameters
    ----------
    path : path
        File of any known format.
    rate_hz : float, optional
        Sampling rate in Hz, where the file tells none or two.
    progress : bool, optional
        Whether to show a progress bar; None: on a terminal, for a file that is large.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, or one that tells two rates.
    """
    contents = read_contents(path)
    sampling = sampling_of(str(path), contents, rate_hz)
    seen = _glances(contents.channels, sampling.rate_hz, progress)
    return Preview(str(path), seen, sampling, _warnings(contents, sampling), contents.date)


def _glances(lines: tuple[Channel, ...], rate_hz: float | None, progress: bool | None) -> tuple[ChannelPreview, ...]:
    found = [Glance(line) for line in lines]
    total = max(count_blocks(line.samples) for line in lines)
    show = progress if total > 1 else False
    with progress_bar("looking through the file", 2 * total, show) as bar:
        for take in (Glance.first, Glance.second):
            # Block by block through all channels, since a file usually has them side by side.
            for blocks in zip_longest(*(blocks_of(line.samples) for line in lines)):
                for each, block in zip(found, blocks, strict=True):
                    if block is not None:
                        take(each, block)
                bar()
    return tuple(each.result(rate_hz) for each in found)


def _warnings(contents: Contents, sampling: Sampling) -> tuple[str, ...]:
    said = list(contents.notes)
    if sampling.rate_hz is None and sampling.even:
        said.append("nothing tells a sampling rate: a plain table; give --rate-hz, or rate_hz in the map")
    if sampling.gaps:
        lost = sum(count for _, count in sampling.gaps)
        row = sampling.gaps[0][0]
        said.append(f"{lost} samples are missing in {len(sampling.gaps)} gaps of the times, the first after row {row}")
    if not sampling.even:
        said.append(
            "the times are uneven: resample_hz in the map draws straight lines between the samples, and of a signal "
            "--disturbance.resample_hz (or --setpoint)"
        )
    sizes = {line.samples.size for line in contents.signals()}
    if len(sizes) > 1:
        said.append(f"channels have unequal lengths: {', '.join(map(str, sorted(sizes)))}")
    return tuple(said)
