"""Looking for a notch: what each allows of kp and ki, on a grid first, then downhill from the best."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from frictionloop.analysis.disturbance import Spectrum
from frictionloop.analysis.state_space import Array
from frictionloop.control.notch import notch_section
from frictionloop.design.detuned import Plants
from frictionloop.design.pi_region import open_stretches

KPS = 20
"""Values of kp looked at for each notch."""
SHARES = (1.0, 0.85, 0.7, 0.55, 0.4)
"""Of the largest ki of a stretch, that are tried where a residual is to be least."""
STARTS = [
    (place, width, share)
    for place in (0.85, 0.92, 0.97, 1.0)
    for width in (0.15, 0.5, 2.0, 7.0)
    for share in (0.01, 0.1, 0.4)
]
"""Notches looked at before the best is refined: centre over resonance, width, depth over width."""
NO_NOTCH = np.log([1.0, 1.0, 1.0])
"""Depth and width alike: the gain is 1 everywhere."""


class NotchSearch:
    """Notches x = (log centre over resonance, log width, log depth over width), and the gains that go with each."""

    def __init__(
        self, plants: Plants, peaks: Sequence[float], resonance_hz: float, disturbance: Spectrum | None
    ) -> None:
        self.plants, self.peaks, self.resonance_hz = plants, peaks, resonance_hz
        self.density = None if disturbance is None else np.asarray(disturbance(plants.frequency_hz), dtype=float)

    def best(self) -> Array:
        """Return the best notch of a grid, refined (Nelder and Mead)."""
        grid = np.log(np.array(STARTS))
        start = grid[int(np.argmin([self.gains(x)[0] for x in grid]))]
        simplex = start + np.vstack([np.zeros(3), np.diag([0.03, 0.3, 0.5])])
        options = {"initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-5, "maxfev": 120}
        return np.asarray(minimize(lambda x: self.gains(x)[0], start, method="Nelder-Mead", options=options).x)

    def notch(self, x: Array) -> tuple[float, float, float]:
        """Return Hz, depth and width, inside what the parameters of the controller take."""
        hz = min(self.resonance_hz * math.exp(x[0]), 0.45 * self.plants.rate_hz)
        width = min(math.exp(x[1]), 10.0)
        return hz, width * min(math.exp(x[2]), 1.0), width

    def gains(self, x: Array, refine: bool = False) -> tuple[float, float, float]:
        """Return cost, kp and ki: the best that a notch allows."""
        plants = self.plants.behind(notch_section(*self.notch(x), self.plants.rate_hz))
        regions = plants.regions(self.peaks)

        def at(kp: float) -> tuple[float, float, float]:
            for low, high in reversed(open_stretches(regions, kp)):
                # Stability changes only across a forbidden stretch: one look inside an open one decides.
                if plants.stable(kp, (low + high) / 2):
                    return min(self._cost(plants, kp, ki) for ki in self._tried(low, high))
            return 1.0, kp, 0.0

        kps = np.linspace(0.0, plants.kp_limit(), KPS)
        tried = [at(kp) for kp in kps]
        best = int(np.argmin([cost for cost, _, _ in tried]))
        if not refine:
            return tried[best]
        around = kps[max(best - 1, 0)], kps[min(best + 1, KPS - 1)]
        finer = minimize_scalar(
            lambda kp: at(kp)[0], bounds=around, method="bounded", options={"xatol": 1e-4 * kps[-1]}
        )
        return min(tried[best], at(float(finer.x)))

    def _tried(self, low: float, high: float) -> list[float]:
        return [high] if self.density is None else [share * high for share in SHARES if share * high > low]

    def _cost(self, plants: Plants, kp: float, ki: float) -> tuple[float, float, float]:
        """Return what is to be least, with the gains: minus ki, or the residual in N less 1."""
        return -ki if self.density is None else self.residual_n(plants, kp, ki) - 1.0, kp, ki

    def residual_n(self, plants: Plants, kp: float, ki: float) -> float:
        """Return the rms of S times the disturbance in the worst loop, NaN without a disturbance."""
        if self.density is None:
            return math.nan
        power = self.density / np.abs(plants.returned(kp, ki)) ** 2
        return float(np.sqrt(np.max(np.trapezoid(power, plants.frequency_hz, axis=1))))
