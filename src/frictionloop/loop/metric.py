"""What a metric is: a tally that the kernel keeps of the control periods, and the number that is made of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from frictionloop.quantities.class_help import Brief, brief
from frictionloop.quantities.compile_cache import keep_compiled
from frictionloop.quantities.scalar_math import biquad_step, fma, step

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


FADE_S = 0.01
"""Time constant of each of the two low-passes that fade the residual (assumed)."""


class Section(NamedTuple):
    """A section of the weighting filter: its state and its coefficients."""

    s1: float
    s2: float
    b0: float
    b1: float
    b2: float
    a1: float
    a2: float


class Felt(NamedTuple):
    """The sum of squares, the fade with its gain per period, and the filter."""

    felt2: float
    gain: float
    fade_1: float
    fade_2: float
    first: Section
    second: Section
    third: Section
    fourth: Section
    fifth: Section


@step
def filtered(section: Section, x: float) -> tuple[Section, float]:
    """Return a section after a sample, and what comes out of it."""
    s1, s2, b0, b1, b2, a1, a2 = section
    s1, s2, y = biquad_step(s1, s2, x, b0, b1, b2, a1, a2)
    return Section(s1, s2, b0, b1, b2, a1, a2), y


@step
def feel(state: Felt, sample: Sample, dt: float) -> Felt:
    """Fade and filter the residual, and add its square."""
    felt2, gain, fade_1, fade_2, first, second, third, fourth, fifth = state
    fade_1 = fma(gain, sample.scored - fade_1, fade_1)
    fade_2 = fma(gain, fade_1 - fade_2, fade_2)
    first, x = filtered(first, (sample.f_a - sample.f_r) * fade_2)
    second, x = filtered(second, x)
    third, x = filtered(third, x)
    fourth, x = filtered(fourth, x)
    fifth, x = filtered(fifth, x)
    x *= sample.counts
    return Felt(fma(x, x, felt2), gain, fade_1, fade_2, first, second, third, fourth, fifth)


@step
def faded_and_filtered(gain: float, sos: Any, residual: Any, scored: Any, felt: Any) -> None:
    """Fade a residual where it is not scored, filter it by sections (sections, 6), and write it to ``felt``."""
    fade_1, fade_2 = 0.0, 0.0
    states = np.zeros((sos.shape[0], 2))
    for k in range(residual.size):
        fade_1 = fma(gain, scored[k] - fade_1, fade_1)
        fade_2 = fma(gain, fade_1 - fade_2, fade_2)
        x = residual[k] * fade_2
        for i in range(sos.shape[0]):
            b0, b1, b2, _, a1, a2 = sos[i]
            states[i, 0], states[i, 1], x = biquad_step(states[i, 0], states[i, 1], x, b0, b1, b2, a1, a2)
        felt[k] = x * scored[k]


keep_compiled(faded_and_filtered, "felt")


def fade_gain(rate_hz: float) -> float:
    """Return the gain per control period of each of the low-passes that fade."""
    return 1.0 - math.exp(-1.0 / (FADE_S * rate_hz))


def _start(setpoint: Any, rate_hz: float) -> Felt:
    from frictionloop.perception.weighting import weighting_sos  # half a second of scipy, not needed for every run

    sections = [Section(0.0, 0.0, b0, b1, b2, a1, a2) for b0, b1, b2, _, a1, a2 in weighting_sos(rate_hz).tolist()]
    return Felt(0.0, fade_gain(rate_hz), 0.0, 0.0, *sections)


FELT = Tally("felt", feel, Felt, _start, everywhere=True)
