"""PI gains and notches within limits on Ms: stretches of ki that no frequency forbids, and the best of all kp."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import count
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from frictionloop.analysis.disturbance import Spectrum
from frictionloop.analysis.state_space import Array
from frictionloop.control.notch import notch_section, section_response
from frictionloop.design.plants import Plants
from frictionloop.loop.progress import step

KPS = 20
"""Values of kp looked at."""
SHARES = (1.0, 0.85, 0.7, 0.55, 0.4)
"""Of the largest ki of a stretch, that are tried where a residual is to be least."""
NO_GAINS = 1.0
"""Cost where no ki holds: more than that of any gains."""


class Gains(NamedTuple):
    """PI gains, and what was to be least."""

    cost: float
    """Minus ki, or with a disturbance the largest residual in N less 1."""
    kp: float
    ki: float


def best_gains(plants: Plants, peaks: Sequence[float], density: Array | None = None, refine: bool = False) -> Gains:
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

    kps = np.linspace(0.0, plants.kp_limit(), KPS)
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


STARTS = [
    (place, width, share)
    for place in (0.85, 0.92, 0.97, 1.0)
    for width in (0.15, 0.5, 2.0, 7.0)
    for share in (0.01, 0.1, 0.4)
]
"""Notches looked at before the best is refined: centre over resonance, width, depth over width."""
REFINED = 120
"""Most notches that are looked at to refine it."""


class NotchSearch:
    """Notches x = (log centre over resonance, log width, log depth over width), and the gains that go with each."""

    def __init__(
        self, plants: Plants, peaks: Sequence[float], resonance_hz: float, disturbance: Spectrum | None
    ) -> None:
        self.plants, self.peaks, self.resonance_hz = plants, peaks, resonance_hz
        self.density = None if disturbance is None else np.asarray(disturbance(plants.frequency_hz), dtype=float)

    def best(self) -> Array:
        """Return the best notch of a grid, refined (Nelder and Mead)."""
        counted = count(1)

        def cost(x: Array) -> float:
            step(f"notch {next(counted)} of at most {len(STARTS) + REFINED}")
            return self.gains(x).cost

        grid = np.log(np.array(STARTS))
        start = grid[int(np.argmin([cost(x) for x in grid]))]
        simplex = start + np.vstack([np.zeros(3), np.diag([0.03, 0.3, 0.5])])
        options = {"initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-5, "maxfev": REFINED}
        return np.asarray(minimize(cost, start, method="Nelder-Mead", options=options).x)

    def notch(self, x: Array) -> tuple[float, float, float]:
        """Return Hz, depth and width, inside what the parameters of the controller take."""
        hz = min(self.resonance_hz * math.exp(x[0]), 0.45 * self.plants.rate_hz)
        width = min(math.exp(x[1]), 10.0)
        return hz, width * min(math.exp(x[2]), 1.0), width

    def behind(self, x: Array) -> Plants:
        """Return the plants behind a notch."""
        rate_hz = self.plants.rate_hz
        return self.plants.behind(
            section_response(notch_section(*self.notch(x), rate_hz), self.plants.frequency_hz, rate_hz)
        )

    def gains(self, x: Array, refine: bool = False) -> Gains:
        """Return the best gains that a notch allows."""
        return best_gains(self.behind(x), self.peaks, self.density, refine)
