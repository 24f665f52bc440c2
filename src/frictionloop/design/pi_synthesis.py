"""The simplest re-tuned controller: the PI gains that hold at every operating point of a band."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from frictionloop.analysis.linear import LinearLoop, operating_band
from frictionloop.analysis.margins import Margins
from frictionloop.design.gain_search import UNFOUND, WorstFew, gains_reached
from frictionloop.design.plants import Plants
from frictionloop.findings import Condition
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError, must_be


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
    points = operating_band(system) if isinstance(system, System) else list(system)
    if not points:
        raise FrictionloopError("system = []: must be a System or at least one LinearLoop")
    peaks = _peaks(sensitivity_peak, len(points))
    _, kp, ki = WorstFew().gains(Plants.of(points), peaks, None, refine=True)
    found = Retuned(kp, ki, tuple(loop.with_gains(kp, ki) for loop in points))
    if ki <= max(least_ki, 0.0):
        raise FrictionloopError(_too_little(found, least_ki), UNFOUND)
    return found


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
