"""The notch that allows the best gains within limits on Ms: a grid of notches, and the best of them refined."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import count

import numpy as np
from scipy.optimize import minimize

from frictionloop.analysis.disturbance import Spectrum
from frictionloop.analysis.state_space import Array
from frictionloop.control.notch import notch_section, section_response
from frictionloop.design.gain_search import Gains
from frictionloop.design.plants import Plants
from frictionloop.design.worst_few import WorstFew
from frictionloop.loop.progress import step

STARTS = [
    (place, width, share)
    for place in (0.85, 0.92, 0.97, 1.0)
    for width in (0.15, 0.5, 2.0, 7.0)
    for share in (0.01, 0.1, 0.4)
]
"""Notches looked at before the best is refined: centre over resonance, width, depth over width."""
WIDEST = 10.0
"""Largest width of a notch that is looked at, the one that the controller takes."""
REFINED = 120
"""Most notches that are looked at to refine it."""


class NotchSearch:
    """Notches x = (log centre over resonance, log width, log depth over width), and the gains that go with each."""

    def __init__(
        self, plants: Plants, peaks: Sequence[float], resonance_hz: float, disturbance: Spectrum | None
    ) -> None:
        self.plants, self.peaks, self.resonance_hz = plants, peaks, resonance_hz
        self._few = WorstFew()
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
        width = min(math.exp(x[1]), WIDEST)
        return hz, width * min(math.exp(x[2]), 1.0), width

    def behind(self, x: Array) -> Plants:
        """Return the plants behind a notch."""
        rate_hz = self.plants.rate_hz
        return self.plants.behind(
            section_response(notch_section(*self.notch(x), rate_hz), self.plants.frequency_hz, rate_hz)
        )

    def gains(self, x: Array, refine: bool = False) -> Gains:
        """Return the best gains that a notch allows."""
        return self._few.gains(self.behind(x), self.peaks, self.density, refine)
