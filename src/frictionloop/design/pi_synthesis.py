"""PI gains within limits on Ms: stretches of ki that no frequency forbids, the best of all kp, over a band."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from frictionloop.analysis.linear import LinearLoop, operating_band
from frictionloop.analysis.margins import Margins
from frictionloop.design.plant_set import Plants
from frictionloop.findings import Condition
from frictionloop.parameters import System
from frictionloop.quantities import Array, FrictionloopError, must_be

KPS = 20
"""Values of kp looked at."""
SHARES = (1.0, 0.85, 0.7, 0.55, 0.4)
"""Of the largest ki of a stretch, that are tried where a residual is to be least."""
NO_GAINS = 1.0
"""Cost where no ki holds: more than that of any gains."""

UNFOUND = "NO-GAINS"
"""Code of a search that ends below the least ki worth having."""


class Gains(NamedTuple):
    """PI gains, and what was to be least."""

    cost: float
    """Minus ki, or with a disturbance the largest residual in N less 1."""
    kp: float
    ki: float


def best_gains(
    plants: Plants,
    peaks: Sequence[float],
    density: Array | None = None,
    refine: bool = False,
    most_kp: float | None = None,
) -> Gains:
    """Return the PI gains of least cost with which every plant is stable and keeps its Ms; ki = 0 if there are none.

    Parameters
    ----------
    plants
        What is controlled.
    peaks
        Largest Ms of each plant.
    density
        Disturbance whose residual is to be least, N^2/Hz at the plants' frequencies. None: ki is to be largest.
    refine
        Look between the values of kp too.
    most_kp
        Largest kp. None: that of the plants.
    """

    def cost(kp: float, ki: float) -> float:
        return -ki if density is None else float(np.max(plants.residual_n(plants.pi(kp, ki), density))) - 1.0

    def at(kp: float) -> Gains:
        for low, high in reversed(open_stretches(plants, peaks, kp)):
            # Stability changes only across a forbidden stretch: one look inside an open one decides.
            if plants.stable(plants.pi(kp, (low + high) / 2)).all():
                tried = [high] if density is None else [share * high for share in SHARES if share * high > low]
                return min(Gains(cost(kp, ki), kp, ki) for ki in tried)
        return Gains(NO_GAINS, kp, 0.0)

    kps = np.linspace(0.0, plants.kp_limit() if most_kp is None else most_kp, KPS)
    tried = [at(float(kp)) for kp in kps]
    best = int(np.argmin([each.cost for each in tried]))
    if not refine:
        return tried[best]
    around = kps[max(best - 1, 0)], kps[min(best + 1, KPS - 1)]
    options = {"xatol": 1e-6 * kps[-1]}
    finer = minimize_scalar(lambda kp: at(kp).cost, bounds=around, method="bounded", options=options)
    return min(tried[best], at(float(finer.x)))


def forbidden(plants: Plants, peaks: Sequence[float], kp: float) -> Array:
    """Return the stretches of ki that some frequency of some plant forbids, shape (stretches, 2), overlapping.

    At each frequency |1 + (kp + ki X) H| < 1/Ms is an ellipse of gains: with X = Ts/(z - 1) it is
    a ki^2 + 2 b ki + c < 0, a = |X H|^2, b = Re((1 + kp H)* X H), c = |1 + kp H|^2 - 1/Ms^2.
    """
    rest, turned = 1.0 + kp * plants.responses, plants.integral * plants.responses
    a, b = np.abs(turned) ** 2, np.real(np.conj(rest) * turned)
    c = np.abs(rest) ** 2 - np.asarray(peaks, dtype=float)[:, None] ** -2
    inside = b**2 > a * c
    a, b, c = a[inside], b[inside], c[inside]
    root = np.sqrt(b**2 - a * c)
    return np.asarray(np.column_stack([-b - root, -b + root]) / a[:, None])


def open_stretches(plants: Plants, peaks: Sequence[float], kp: float) -> list[tuple[float, float]]:
    """Return the stretches of ki > 0 that no frequency of any plant forbids, rising.

    What lies above the last forbidden ki is left out: there a sampled loop is unstable.
    """
    closed = forbidden(plants, peaks, kp)
    closed = closed[np.argsort(closed[:, 0])]
    reached = np.maximum.accumulate(np.append(0.0, closed[:, 1]))
    return [(float(end), float(start)) for end, start in zip(reached, closed[:, 0], strict=False) if start > end]


def gains_reached(least_ki: float, kp: float, ki: float) -> str:
    """Return how far a search for gains got."""
    return f"least_ki = {least_ki:g} 1/s: no gains within Ms, farthest kp = {kp:.3g}, ki = {ki:.4g} 1/s"


AT_ONCE = 4
"""Plants beyond their limit that are looked at from then on, the worst first (chosen for speed)."""
ROUNDING = 1e-9
"""Share by which a limit or a residual may be missed by rounding."""


@dataclass
class WorstFew:
    """Plants, by number, that have limited gains so far: of hundreds a handful, and the same for notches alike."""

    few: set[int] = field(default_factory=lambda: {0})

    def gains(self, plants: Plants, peaks: Sequence[float], density: Array | None, refine: bool) -> Gains:
        """Return `best_gains` of all plants.

        The best gains of fewer plants are no dearer: if they hold on all, and leave no more on any, no better ones do.
        With a disturbance that is so up to the steps of the ki that are tried.
        """
        limits, most_kp = np.asarray(peaks, dtype=float), plants.kp_limit()
        while True:
            some = sorted(self.few)
            found = best_gains(plants.some(some), limits[some].tolist(), density, refine, most_kp)
            if found.ki == 0.0 or not (more := _beyond(plants, limits, density, found) - self.few):
                return found
            self.few |= more


def _beyond(plants: Plants, limits: Array, density: Array | None, found: Gains) -> set[int]:
    """Return the worst plants on which gains are unstable, beyond their Ms, or leave more of a disturbance."""
    law = plants.pi(found.kp, found.ki)
    returned = np.min(np.abs(plants.returned(law)), axis=1) * limits
    excess = np.where(plants.stable(law), 1.0 - returned, np.inf)
    worst = np.argsort(-excess)[:AT_ONCE]
    more = {int(each) for each in worst if excess[each] > ROUNDING}
    if density is not None:
        left = plants.residual_n(law, density)
        if left.max() > (found.cost + 1.0) * (1.0 + ROUNDING):
            more.add(int(np.argmax(left)))
    return more


@dataclass(frozen=True, eq=False, repr=False)
class Retuned:
    """PI gains, and the loops they were chosen for with these gains in them."""

    kp: float
    """Proportional gain, N/N."""
    ki: float
    """Integral gain, 1/s."""
    loops: tuple[LinearLoop, ...]
    """One per operating point."""

    @cached_property
    def margins(self) -> tuple[Margins, ...]:
        """Their margins, in the same order; found when asked for."""
        return tuple(loop.margins() for loop in self.loops)

    def __repr__(self) -> str:
        peak = self.worst[1].sensitivity_peak
        return f"Retuned(kp={self.kp:.6g}, ki={self.ki:.6g}, sensitivity_peak={peak:.4g}, loops={len(self.loops)})"

    @property
    def overrides(self) -> dict[str, float]:
        """The gains as overrides for ``System.evolve``."""
        return {"controller.kp": self.kp, "controller.ki": self.ki}

    @property
    def worst(self) -> tuple[LinearLoop, Margins]:
        """The loop with the largest Ms, and its margins."""
        return max(zip(self.loops, self.margins, strict=True), key=lambda pair: pair[1].sensitivity_peak)


def retune(
    system: System | Sequence[LinearLoop], sensitivity_peak: float | Sequence[float] = 1.5, least_ki: float = 0.0
) -> Retuned:
    """Return the PI gains with the largest ki whose Ms stays below a limit at every operating point.

    The rule of Astrom, Panagopoulos and Hagglund ("Design of PI controllers based on non-convex optimization",
    Automatica 34, 1998): of a slow disturbance w/ki is left, so the largest ki is best, and Ms = max |1/(1 + G)| bounds
    every margin: phase margin >= 2 asin(1/(2 Ms)), gain margin >= Ms/(Ms - 1).

    Parameters
    ----------
    system
        The loop, at the operating points of `operating_band`; or one or more loops of your own choice. The gains they
        have are not used.
    sensitivity_peak
        Largest Ms, above 1. It is met to 0.1 %. Or one for each of the loops.
    least_ki
        Least ki worth having, 1/s, above which the search must get.

    Raises
    ------
    FrictionloopError
        The law is not PI, or no gains reach ``least_ki``: the line says how far they get and what limits them. An Ms
        that no loop has, or no operating point.
    """
    points = points_of(system)
    peaks = _peaks(sensitivity_peak, len(points))
    _, kp, ki = WorstFew().gains(Plants.of(points), peaks, None, refine=True)
    found = Retuned(kp, ki, tuple(loop.with_gains(kp, ki) for loop in points))
    if ki <= max(least_ki, 0.0):
        raise FrictionloopError(_too_little(found, least_ki), UNFOUND)
    return found


def points_of(system: System | Sequence[LinearLoop]) -> list[LinearLoop]:
    """Return loops of somebody's choice, or those of a System at its `operating_band`; refuses none."""
    points = operating_band(system) if isinstance(system, System) else list(system)
    if not points:
        raise FrictionloopError("system = []: needs a System or LinearLoop")
    return points


def _peaks(sensitivity_peak: float | Sequence[float], loops: int) -> list[float]:
    """Return the largest Ms of each loop."""
    peaks = [sensitivity_peak] * loops if isinstance(sensitivity_peak, float | int) else list(sensitivity_peak)
    for peak in peaks:
        if not (math.isfinite(peak) and peak > 1):
            raise must_be("sensitivity_peak", peak, "above 1, e.g. 1.5")
    if len(peaks) != loops:
        raise FrictionloopError(f"sensitivity_peak = {peaks}: one number, or {loops}")
    return peaks


def _too_little(found: Retuned, least_ki: float) -> str:
    loop, _ = found.worst
    grid = loop.search_grid()
    peak_hz = grid[np.argmax(np.abs(loop.responses(grid)["S"]))]
    at = loop.elements
    where = Condition(force_n=at.force_n, occluded=at.occluded)
    return f"{gains_reached(least_ki, found.kp, found.ki)}, |S| peaks at {peak_hz:.3g} Hz, {where}"
