"""Calls shared out over workers: threads of this process, or whatever joblib back end the caller has made active."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import joblib
from joblib.parallel import ThreadingBackend, get_active_backend

from frictionloop.loop.timing import is_whole
from frictionloop.quantities import FrictionloopError

R = TypeVar("R")


def worker_count(n_jobs: int | None) -> int:
    """Return the number of workers asked for, or the processor cores that this process may use."""
    if n_jobs is not None and not (is_whole(n_jobs) and n_jobs >= 1):
        raise FrictionloopError(f"n_jobs = {n_jobs!r}: must be a whole number of workers, at least 1, or None")
    if n_jobs is not None:
        return n_jobs
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def shared_out(function: Callable[..., R], calls: Iterable[tuple[Any, ...]], workers: int) -> Generator[R, None, None]:
    """Yield ``function(*call)`` of each call: in their order from threads, as they are done from a joblib back end.

    joblib looks at its threads every 10 ms, a tenth of what a map of gains takes; those of the standard library say
    when they are done. What has not begun is dropped when the caller closes the generator or it raises.
    """
    active, _ = get_active_backend(prefer="threads")
    if not isinstance(active, ThreadingBackend):
        job = joblib.delayed(function)
        yield from joblib.Parallel(workers, return_as="generator_unordered")(job(*call) for call in calls)
    elif workers == 1:
        yield from (function(*call) for call in calls)
    else:
        pool = ThreadPoolExecutor(workers)
        try:
            yield from pool.map(lambda call: function(*call), calls)
        finally:
            pool.shutdown(cancel_futures=True)
