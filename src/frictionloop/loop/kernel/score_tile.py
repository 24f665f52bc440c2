"""The tiles of streaming metrics: sums over the scored periods, so that memory does not grow with duration.

`loop.formulas` turns them into numbers. Only periods whose ``scored`` row is 1 count.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from frictionloop.loop.kernel.lift import lift
from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.quantities.arithmetic import fma, step

IDENTITY, SATURATION, REGRESSION, BOUND, PERCEPTION, STEPS = 1, 2, 4, 8, 16, 32
"""Groups of streaming sums a run may ask for, as bits."""


class ScoreRows(NamedTuple):
    """Rows of the sums, in the order of the first fields of `loop.formulas.Sums`."""

    error2: int
    r: int
    r2: int
    saturated: int
    f: int
    f2: int
    fr: int
    shortfall2: int
    periods: int


@step
def identity_step(error2, r_sum, r2, count, f_r, g, d, shift, scored):  # type: ignore[no-untyped-def]
    """Squares of the error f_a - f_r, f_r and its squares (less a constant), and the periods that count."""
    error, r = g + d - f_r, f_r - shift
    return (
        fma(error * scored, error, error2),
        fma(r * scored, 1.0, r_sum),
        fma(r * scored, r, r2),
        fma(scored, 1.0, count),
    )


@step
def saturation_step(sum_, saturated, scored):  # type: ignore[no-untyped-def]
    """Periods with a clamped command."""
    return fma(saturated * scored, 1.0, sum_)


@step
def regression_step(f_sum, f2, fr, f_r, g, d, shift, scored):  # type: ignore[no-untyped-def]
    """f_a, its squares, and its products with f_r, both less a constant."""
    f = g + d - shift
    return fma(f * scored, 1.0, f_sum), fma(f * scored, f, f2), fma(f * scored, f_r - shift, fr)


@step
def bound_step(shortfall2, f_r, d, floor, nominal, scored):  # type: ignore[no-untyped-def]
    """Squares of what no command could make up for: f_r clipped to what is reachable, less f_r."""
    short = min(max(f_r, floor + d), nominal + d) - f_r
    return fma(short * scored, short, shortfall2)


def build_scores(lifting: Lifting, groups: int) -> Any:
    """Return the tile that adds the sums of some groups: what all need, and up to three more."""
    sums = ScoreRows(*rows("sums"))
    r, g, d, shift, scored = (ROW[name] for name in ("setpoint", "friction", "disturbance", "shift", "scored"))
    identity, regression = (sums.error2, sums.r, sums.r2, sums.periods), (sums.f, sums.f2, sums.fr)
    add = lift(lifting, identity_step, (*identity, r, g, d, shift, scored), identity)
    saturate = lift(lifting, saturation_step, (sums.saturated, ROW["saturated"], scored), sums.saturated)
    regress = lift(lifting, regression_step, (*regression, r, g, d, shift, scored), regression)
    reach = ROW["floor"], ROW["nominal"]
    bound = lift(lifting, bound_step, (sums.shortfall2, r, d, *reach, scored), sums.shortfall2)
    saturates, regresses, bounds = (groups & each > 0 for each in (SATURATION, REGRESSION, BOUND))

    @lifting.compiled
    def score(s, n, k, at, o):  # type: ignore[no-untyped-def]
        if k >= o.score_from:
            add(s, n)
            if saturates:
                saturate(s, n)
            if regresses:
                regress(s, n)
            if bounds:
                bound(s, n)

    return score
