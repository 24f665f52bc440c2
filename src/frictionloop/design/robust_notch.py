"""The robust default: PI and notch with the least residual whose margins hold on a resonance that is not known well."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np
from scipy.optimize import minimize

from frictionloop.analysis.disturbance_spectrum import Spectrum
from frictionloop.analysis.linear import LinearLoop
from frictionloop.analysis.operating_point import check_reach
from frictionloop.control.notch import notch_section, section_response
from frictionloop.design.pi_synthesis import UNFOUND, Gains, WorstFew, best_gains, gains_reached, points_of
from frictionloop.design.plant_set import Plants, shifted, stiffened
from frictionloop.loop.progress import step
from frictionloop.parameters import SuspendedSensor, System
from frictionloop.quantities import Array, FrictionloopError, must_be

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


@dataclass(frozen=True)
class Notched:
    """Gains and notch, and how they hold at the worst of the operating points and resonances they were made for."""

    kp: float
    """Proportional gain, N/N."""
    ki: float
    """Integral gain, 1/s."""
    notch_hz: float
    notch_depth: float
    notch_width: float
    overdrive: bool
    """Whether they are for a plate under overdrive."""
    sensitivity_peak: float
    """Largest Ms over operating points and resonances."""
    residual_n: float
    """Largest rms of S times the disturbance, N; NaN without a spectrum."""

    @property
    def overrides(self) -> dict[str, Any]:
        """Gains and notch as overrides for ``System.evolve``."""
        names = ("kp", "ki", "notch_hz", "notch_depth", "notch_width", "overdrive")
        return {"controller.kind": "notch_pi"} | {f"controller.{name}": getattr(self, name) for name in names}


def retune_notch(
    system: System | Sequence[LinearLoop],
    sensitivity_peak: float | Mapping[float, float] = 1.5,
    resonance_error: float = 0.05,
    disturbance: Spectrum | None = None,
    overdrive: bool = False,
    least_ki: float = 0.0,
) -> Notched:
    """Return PI gains and a notch with the least residual such that Ms stays below a limit, whatever the resonance.

    At each operating point Ms = max |1/(1 + G)| is held with the resonance of the plant at 1 - e, 1 and 1 + e times
    that of the system. For a notch and a kp the ki allowed are exact (`open_stretches`); notch and kp are searched.
    Objective is the largest ki, as for `retune`, or the least rms of S times a disturbance, sqrt(int |S|^2 D df), at
    the worst operating point.

    Parameters
    ----------
    system
        The loop, at the operating points of `operating_band`; or loops of your own choice. Their gains are not used.
    sensitivity_peak
        Largest Ms, above 1. It is met to 0.1 %. Or limits that widen with the error of the resonance, in place of
        ``resonance_error``: {0.0: 1.7, 0.05: 2.0, 0.1: 2.6}.
    resonance_error
        Largest relative error of the resonance, e, 0 to 0.5.
    disturbance
        Power density of the disturbance in N^2/Hz over frequencies in Hz.
    overdrive
        Design for the plate under overdrive: the lag of the believed plate is then out of the loop.
    least_ki
        Least ki worth having, 1/s, above which the search must get.

    Raises
    ------
    FrictionloopError
        No controller of this form reaches ``least_ki`` within the margins: the line names what limits it. A value out
        of range, a sensor without a resonance, or no operating point.
    """
    limits = _limits(sensitivity_peak, resonance_error)
    points = _points(system)
    loops, _, peaks = zip(*shifted(points, limits), strict=True)
    centre = _resonance_hz(points[0].system)
    x = NotchSearch(Plants.of(loops, overdrive, fine=False), peaks, centre, disturbance).best()
    step("its gains, on a finer grid of frequencies")
    fine = NotchSearch(Plants.of(loops, overdrive), peaks, centre, disturbance)
    _, kp, ki = fine.gains(x, refine=True)
    plants, density = fine.behind(x), fine.density
    law = plants.pi(kp, ki)
    peak = float(1.0 / np.min(np.abs(plants.returned(law))))
    residual = math.nan if density is None else float(np.max(plants.residual_n(law, density)))
    found = Notched(kp, ki, *fine.notch(x), overdrive, peak, residual)
    if ki <= max(least_ki, 0.0):
        raise FrictionloopError(_too_little(found, points, limits, least_ki), UNFOUND)
    return found


def _points(system: System | Sequence[LinearLoop]) -> list[LinearLoop]:
    if isinstance(system, System):
        check_reach(system)
        system = system if hasattr(system.controller, "kp") else system.evolve({"controller.kind": "pi"})
    return points_of(system)


def _resonance_hz(system: System) -> float:
    sensor = system.sensor
    if not isinstance(sensor, SuspendedSensor):
        raise FrictionloopError(f"sensor.kind = {sensor.kind!r}: must be 'suspended'")
    return sensor.resonance_hz


def _limits(sensitivity_peak: float | Mapping[float, float], resonance_error: float) -> dict[float, float]:
    """Return the largest Ms by error of the resonance."""
    if isinstance(sensitivity_peak, Mapping):
        limits = dict(sensitivity_peak)
    else:
        limits = {0.0: sensitivity_peak, resonance_error: sensitivity_peak}
    for error, peak in limits.items():
        if not (math.isfinite(peak) and peak > 1):
            raise must_be("sensitivity_peak", peak, "above 1, e.g. 1.5")
        if not 0 <= error <= 0.5:
            raise must_be("resonance_error", error, "from 0 to 0.5")
    if not limits:
        raise FrictionloopError("sensitivity_peak = {}: needs one limit")
    return limits


def _too_little(found: Notched, points: Sequence[LinearLoop], limits: Mapping[float, float], least_ki: float) -> str:
    """Return what limits: the resonance if springs that follow at once would do, the delay and the lags if not."""
    stiff = Plants.of([stiffened(loop) for loop in points], found.overdrive)
    ki = best_gains(stiff, [min(limits.values())] * len(points)).ki
    return f"{gains_reached(least_ki, found.kp, found.ki)}; without the resonance ki = {ki:.4g} 1/s"
