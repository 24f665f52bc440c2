"""The sums that the metrics of this package are made of.

Sums are of f_r and f_a less a constant near their mean, so that differences of squares keep their digits.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from frictionloop.loop.felt_tally import FELT
from frictionloop.loop.metric import Sample, Tally
from frictionloop.loop.step_tally import STEP_TIMES
from frictionloop.quantities.arithmetic import fma, step


class Errors(NamedTuple):
    """Squares of the error f_a - f_r, f_r and its squares, and periods with a clamped command."""

    shift: float
    error2: float
    r: float
    r2: float
    saturated: float


@step
def add_errors(state: Errors, sample: Sample, dt: float) -> Errors:
    """Add a period."""
    shift, error2, r_sum, r2, saturated = state
    error, r = sample.f_a - sample.f_r, sample.f_r - shift
    return Errors(shift, fma(error, error, error2), r_sum + r, fma(r, r, r2), saturated + sample.saturated)


class Regression(NamedTuple):
    """f_r and f_a, their squares and their products."""

    shift: float
    r: float
    r2: float
    f: float
    f2: float
    fr: float


@step
def add_regression(state: Regression, sample: Sample, dt: float) -> Regression:
    """Add a period."""
    shift, r_sum, r2, f_sum, f2, fr = state
    r, f = sample.f_r - shift, sample.f_a - shift
    return Regression(shift, r_sum + r, fma(r, r, r2), f_sum + f, fma(f, f, f2), fma(f, r, fr))


class Shortfall(NamedTuple):
    """f_r, its squares, and those of what no command could make up for: f_r clipped to what is reachable, less f_r."""

    shift: float
    r: float
    r2: float
    shortfall2: float


@step
def add_shortfall(state: Shortfall, sample: Sample, dt: float) -> Shortfall:
    """Add a period."""
    shift, r_sum, r2, shortfall2 = state
    r, short = sample.f_r - shift, min(max(sample.f_r, sample.floor + sample.d), sample.limit + sample.d) - sample.f_r
    return Shortfall(shift, r_sum + r, fma(r, r, r2), fma(short, short, shortfall2))


def _from(shape: Any) -> Any:
    """Return the start of sums: none yet, less the offset of the set-point."""
    return lambda setpoint, rate_hz: shape(getattr(setpoint, "offset_n", 0.0), *[0.0] * (len(shape._fields) - 1))


ERRORS = Tally("errors", add_errors, Errors, _from(Errors))
REGRESSION = Tally("regression", add_regression, Regression, _from(Regression))
SHORTFALL = Tally("shortfall", add_shortfall, Shortfall, _from(Shortfall))
TALLIES = (ERRORS, REGRESSION, SHORTFALL, STEP_TIMES, FELT)
