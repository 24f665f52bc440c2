"""Hits over recordings: one, several that are one measurement, or one that is too long to be read at once."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import xarray as xr

from frictionloop.identification.hits import Hits, pick_hits
from frictionloop.identification.long import Run, Stretches
from frictionloop.quantities import FrictionloopError


def hits_of(
    recording: Run | Sequence[Run], segment_s: float | None = None, exclude: Collection[int] = ()
) -> Iterator[tuple[xr.Dataset, Hits]]:
    """Yield recordings with their hits, one after the other; hits of several are numbered through."""
    if isinstance(recording, Stretches):
        yield from _hits_of_parts(recording, segment_s, exclude)
    elif isinstance(recording, xr.Dataset) or not isinstance(recording, Sequence):
        yield recording, pick_hits(recording, segment_s, exclude)
    elif len(recording) == 1:
        yield from hits_of(recording[0], segment_s, exclude)
    else:
        yield from _hits_of_several(recording, segment_s, exclude)


def _hits_of_several(
    recordings: Sequence[Run], segment_s: float | None, exclude: Collection[int]
) -> Iterator[tuple[xr.Dataset, Hits]]:
    count = 0
    for run in recordings:
        if isinstance(run, Stretches):
            yield from _hits_of_parts(run, segment_s, exclude)
            continue
        found = pick_hits(run, segment_s, exclude, before=count)
        count += len(found.table)
        yield run, found
    unknown = [number for number in exclude if not 1 <= number <= count]
    if count and unknown:
        raise FrictionloopError(f"exclude = {unknown[0]}: there is no such hit; accepted: 1 to {count}")


def _hits_of_parts(
    parts: Stretches, segment_s: float | None, exclude: Collection[int]
) -> Iterator[tuple[xr.Dataset, Hits]]:
    """Yield the parts in which there are hits, numbered through; refuse if there are none in any."""
    count, refused = 0, None
    for run in parts:
        try:
            found = pick_hits(run, segment_s, exclude, before=count)
        except FrictionloopError as error:
            refused = error
            continue
        count += len(found.table)
        yield run, found
    if refused is not None and not count:
        raise refused
