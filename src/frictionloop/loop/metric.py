"""What a metric is: a tally that the kernel keeps of the control periods, and the number that is made of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from frictionloop.quantities.brief import Brief, brief

if TYPE_CHECKING:
    import xarray as xr


@brief
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
    limit: float
    """Friction without vibration, and ``floor`` under the largest."""
    floor: float
    scored: float
    """1, but 0 while the finger turns or is lifted."""
    counts: float
    """1 where ``scored``, and not before the scored part of a run."""
    valid: float
    """1 where the measurement is of a finger that slides (`Measurement`)."""


@dataclass(frozen=True)
class Tally:
    """State that a run keeps of its periods: ``step(state, sample, dt) -> state`` where a period counts."""

    name: str
    step: Any
    state: type
    start_of: Callable[[Any, float], Any] | None = None
    """(set-point, rate in Hz) -> state before the first period; all zero if not given."""
    everywhere: bool = False
    """The step runs in every period, also where ``sample.counts`` is 0."""


@dataclass(frozen=True)
class Metric:
    """A number per run of this package; any number of metrics may read one tally."""

    tally: Tally
    of: Callable[[Any, Any], Any]
    units: str
    long_name: str


@dataclass(frozen=True)
class StreamingMetric(metaclass=Brief):
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

    @property
    def tally(self) -> Tally:
        """What the kernel keeps."""
        return Tally(self.name, self.step, self.state)


@dataclass(frozen=True)
class RunMetric(metaclass=Brief):
    """A number computed from the traces of a run: ``of(run) -> float``. Each point of a sweep then runs alone."""

    name: str
    of: Callable[[xr.Dataset], float]
    units: str = "1"
    long_name: str = ""


@dataclass(frozen=True)
class AgainMetric:
    """A number of this package that compares a run with others of its system: ``of(run, mask)``."""

    of: Callable[[xr.Dataset, Any], float]
    units: str
    long_name: str
