"""Which PI gains keep the distance of G from -1: for each kp, the stretches of ki that no frequency forbids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frictionloop.analysis.linear import LinearLoop
from frictionloop.analysis.state_space import Complex


@dataclass(frozen=True, eq=False)
class PiRegion:
    """At each frequency |1 + (kp + ki X) H| < 1/Ms is an ellipse of gains, closed to the loop."""

    plant: Complex
    """H, force command to measured force, at the frequencies looked at."""
    integral: Complex
    """X = Ts/(z - 1) at the same frequencies."""
    sensitivity_peak: float
    """Ms."""

    @classmethod
    def of(cls, loop: LinearLoop, sensitivity_peak: float) -> PiRegion:
        """Return the region of a loop's plate and sensor; its gains are not used."""
        frequency = np.append(loop.search_grid(), loop.nyquist_hz)
        period_s = loop.plant.period_s
        integral = np.asarray(period_s / np.expm1(2j * np.pi * period_s * frequency), dtype=np.complex128)
        return cls(loop.plant.response(frequency)[:, 1, 0], integral, sensitivity_peak)

    def closed(self, kp: float) -> np.ndarray:
        """Return the stretches of ki that some frequency forbids, shape (stretches, 2), overlapping.

        a ki^2 + 2 b ki + c < 0 with a = |X H|^2, b = Re((1 + kp H)* X H), c = |1 + kp H|^2 - 1/Ms^2.
        """
        rest, turned = 1.0 + kp * self.plant, self.integral * self.plant
        a, b = np.abs(turned) ** 2, np.real(np.conj(rest) * turned)
        c = np.abs(rest) ** 2 - self.sensitivity_peak**-2
        inside = b**2 > a * c
        a, b, c = a[inside], b[inside], c[inside]
        root = np.sqrt(b**2 - a * c)
        return np.column_stack([-b - root, -b + root]) / a[:, None]


def open_stretches(regions: Sequence[PiRegion], kp: float) -> list[tuple[float, float]]:
    """Return the stretches of ki > 0 that no frequency of any loop forbids, rising.

    What lies above the last forbidden ki is left out: there a sampled loop is unstable.
    """
    forbidden = np.concatenate([region.closed(kp) for region in regions])
    forbidden = forbidden[np.argsort(forbidden[:, 0])]
    reached = np.maximum.accumulate(np.append(0.0, forbidden[:, 1]))
    return [(float(end), float(start)) for end, start in zip(reached, forbidden[:, 0], strict=False) if start > end]
