"""Calls shared out over workers: threads of this process, or whatever joblib back end the caller has made active.

Many runs with traces go out so: those of one structure side by side, at little more than the cost of one.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Generator, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from typing import Any, TypeVar

import joblib
import xarray as xr
from joblib.parallel import ThreadingBackend, get_active_backend

from frictionloop.loop.kernel.lane_grouping import tiles_of
from frictionloop.loop.kernel.tile_compatibility import structure
from frictionloop.loop.simulate import traced
from frictionloop.parameters import System
from frictionloop.quantities.value_checks import whole

R = TypeVar("R")


def worker_count(n_jobs: int | None) -> int:
    """Return the number of workers asked for, or the processor cores that this process may use."""
    if n_jobs is not None:
        return whole("n_jobs", n_jobs, 1)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def shared_out(function: Callable[..., R], calls: Iterable[tuple[Any, ...]], workers: int) -> Generator[R, None, None]:
    """Yield ``function(*call)`` of each call as it is done, by threads or by the joblib back end that is active.

    What has not begun is dropped when the caller closes the generator or a call raises.
    """
    active, _ = get_active_backend(prefer="threads")
    if isinstance(active, ThreadingBackend):
        yield from _threaded(function, deque(calls), workers)
    else:
        job = joblib.delayed(function)
        yield from joblib.Parallel(workers, return_as="generator_unordered")(job(*call) for call in calls)


def _threaded(function: Callable[..., R], waiting: deque[tuple[Any, ...]], workers: int) -> Generator[R, None, None]:
    """Work on the calls beside ``workers - 1`` threads.

    A caller that waited for its threads would be one thread more than cores, and each time it woke it would put two
    that compute on one core. joblib's caller wakes every 10 ms, a tenth of what a map of gains takes.
    """
    done: deque[R] = deque()

    def helped() -> None:
        try:
            while call := _next(waiting):
                done.append(function(*call))
        except BaseException:
            waiting.clear()
            raise

    pool = ThreadPoolExecutor(max(workers - 1, 1))
    helpers = [pool.submit(helped) for _ in range(workers - 1)]
    try:
        while call := _next(waiting):
            yield function(*call)
            while done:
                yield done.popleft()
        for helper in helpers:
            helper.result()
        yield from done
    finally:
        waiting.clear()
        pool.shutdown()


def _next(waiting: deque[tuple[Any, ...]]) -> tuple[Any, ...] | None:
    try:
        return waiting.popleft()
    except IndexError:
        return None


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
    return lanes, [_part_of(run, keep, from_s) for run in traced(systems, seeds, duration_s)]


def _part_of(run: xr.Dataset, keep: tuple[str, ...], from_s: float) -> xr.Dataset:
    rate_hz = 1.0 / float(run["time"][1] - run["time"][0])
    part = run[list(keep)].isel(time=slice(round(from_s * rate_hz), None))
    # A view would keep the traces of the whole tile.
    return part.copy(deep=True)
