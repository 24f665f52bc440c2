"""Metrics from outside: computed sample by sample inside the kernel, or from a whole run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import xarray as xr

from frictionloop.loop.kernel.slab import ROWS
from frictionloop.quantities import trees


class Sample(NamedTuple):
    """What a streaming metric is given of a control period: forces in N, amplitude in um, SI units for the motion."""

    f_r: float
    f_a: float
    f_m: float
    u: float
    a: float
    d: float
    saturated: float
    position: float
    speed: float
    load: float


@dataclass(frozen=True)
class StreamingMetric:
    """A number per run that needs no traces: ``step(state, sample, dt) -> state`` at each scored control period."""

    name: str
    step: Any
    """Compiled with ``fl.step``."""
    state: type
    """Named tuple of numbers, all zero before the first period."""
    of: Callable[[Any, Any], Any]
    """(state with an array over runs for each number, number of scored periods) -> value of each run."""
    units: str = "1"
    long_name: str = ""
    groups: int = 0


@dataclass(frozen=True)
class RunMetric:
    """A number computed from the traces of a run: ``of(run) -> float``. Each point of a sweep then runs alone."""

    name: str
    of: Callable[[xr.Dataset], float]
    units: str = "1"
    long_name: str = ""
    groups: int = 0


def first_rows(metrics: Sequence[StreamingMetric]) -> list[int]:
    """Return the row at which the state of each metric begins, and the row after the last."""
    sizes = [trees.size(each.state) for each in metrics]
    return [ROWS + sum(sizes[:i]) for i in range(len(sizes) + 1)]
