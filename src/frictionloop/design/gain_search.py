"""PI gains within limits on Ms: stretches of ki that no frequency forbids, and the best of all kp."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from frictionloop.analysis.state_space import Array
from frictionloop.design.plants import Plants

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
