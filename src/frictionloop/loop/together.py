"""Many runs with traces: those of one structure run side by side, at little more than the cost of one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import closing

import xarray as xr

from frictionloop.loop.kernel.placing import tiles_of
from frictionloop.loop.kernel.structure import structure
from frictionloop.loop.simulate import traced
from frictionloop.loop.workers import shared_out, worker_count
from frictionloop.parameters import System

Job = tuple[System, int]


def simulate_all(jobs: Iterable[Job], duration_s: float, keep: Sequence[str], from_s: float = 0.0) -> list[xr.Dataset]:
    """Return what ``simulate`` returns for each (system, seed), bit for bit: some of its variables, from a time on.

    Parameters
    ----------
    jobs : iterable of (System, int)
        What to simulate, and with which seed.
    duration_s : float
        Duration of each run in s.
    keep : sequence of str
        Variables to keep; all traces of all runs would seldom fit into memory.
    from_s : float
        Where the kept part begins, in s.

    Raises
    ------
    FrictionloopError
        As ``simulate``.
    """
    asked = list(jobs)
    tiles = tiles_of([structure(system) for system, _ in asked], range(len(asked)))
    calls = ((lanes, [asked[lane] for lane in lanes], duration_s, tuple(keep), from_s) for lanes in tiles)
    found: dict[int, xr.Dataset] = {}
    with closing(shared_out(_run, calls, worker_count(None))) as done:
        for lanes, runs in done:
            found.update(zip(lanes, runs, strict=True))
    return [found[lane] for lane in range(len(asked))]


def _run(
    lanes: list[int], jobs: list[Job], duration_s: float, keep: tuple[str, ...], from_s: float
) -> tuple[list[int], list[xr.Dataset]]:
    """Run one tile and return its lanes and their runs."""
    systems, seeds = zip(*jobs, strict=True)
    return lanes, [_kept(run, keep, from_s) for run in traced(systems, seeds, duration_s)]


def _kept(run: xr.Dataset, keep: tuple[str, ...], from_s: float) -> xr.Dataset:
    rate_hz = 1.0 / float(run["time"][1] - run["time"][0])
    part = run[list(keep)].isel(time=slice(round(from_s * rate_hz), None))
    # A view would keep the traces of the whole tile.
    return part.copy(deep=True)
