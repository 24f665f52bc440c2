"""Many runs with traces: those of one structure run side by side, at little more than the cost of one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import closing

import numpy as np
import xarray as xr

from frictionloop.loop.kernel.lowering import lower
from frictionloop.loop.kernel.placing import tiles_of
from frictionloop.loop.kernel.slab import LANES
from frictionloop.loop.kernel.structure import kernel_of, structure
from frictionloop.loop.kernel.traces import traces_of
from frictionloop.loop.no_number import lanes_without_number
from frictionloop.loop.record import to_dataset
from frictionloop.loop.simulate import check_numbers, run_tile, simulate
from frictionloop.loop.timing import check_memory, check_seed, periods_in
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
    kept = [_kept(run, keep, from_s) for run in _runs(jobs, duration_s)]
    return lanes, kept


def _runs(jobs: list[Job], duration_s: float) -> Iterable[xr.Dataset]:
    if len(jobs) == 1:
        yield simulate(jobs[0][0], duration_s, jobs[0][1])
        return
    systems, seeds = [system for system, _ in jobs], [check_seed(seed) for _, seed in jobs]
    names = traces_of(kernel_of(systems[0]))
    shape = len(names), periods_in(systems[0], duration_s), LANES
    check_memory(8 * int(np.prod(shape)), f"{LANES} runs of {duration_s:g} s")
    traces = np.empty(shape)
    tile = lower(systems, seeds, traces=traces.reshape(-1))
    run_tile(tile, shape[1])
    lost = set(lanes_without_number(tile).tolist())
    for lane, (system, seed) in enumerate(zip(systems, seeds, strict=True)):
        check_numbers(system, traces[names.index("u"), :, lane], lane in lost)
        yield to_dataset(traces[:, :, lane], system, seed)


def _kept(run: xr.Dataset, keep: tuple[str, ...], from_s: float) -> xr.Dataset:
    rate_hz = 1.0 / float(run["time"][1] - run["time"][0])
    part = run[list(keep)].isel(time=slice(round(from_s * rate_hz), None))
    # A view would keep the traces of the whole tile.
    return part.copy(deep=True)
