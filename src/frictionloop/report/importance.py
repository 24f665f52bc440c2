"""How much each number that nobody has measured matters to the loop: margins and residual over its range."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictionloop.analysis import linearise, operating_band, touch_spectrum
from frictionloop.analysis.elements import linearise_contact
from frictionloop.analysis.linear import LinearLoop
from frictionloop.design.pi_synthesis import retune
from frictionloop.identification import Bench
from frictionloop.parameters import FingerFriction, Strokes, System
from frictionloop.quantities import FrictionloopError

RANGES = {
    "plate.frequency_hz": (0.95, 1.05),
    "plate.q": (0.6, 1.6),
    "plate.max_amplitude_um": (0.7, 1.3),
    "controller.delay_s": (0.7, 1.5),
    "sensor.resonance_hz": (0.7, 1.4),
    "sensor.q": (0.4, 2.5),
    "sensor.cutoff_hz": (0.5, 2.0),
    "friction.nominal_n": (0.8, 1.5),
    "friction.susceptibility_per_um2": (0.6, 1.6),
    "finger.stiffness_n_m": (0.5, 2.0),
}
"""Factors between which an unmeasured number of a preset may lie (assumed)."""


POINTS = 400
"""Frequencies of the residual's integral (its error is below a percent)."""


class Importance(NamedTuple):
    """What one assumed number does to the loop."""

    path: str
    low: float
    """Least value that it may have."""
    high: float
    peak_low: float
    """Largest sensitivity Ms with the least value; infinite if unstable, NaN if the set-point is out of reach."""
    peak_high: float
    residual_low_n: float
    """What the loop leaves of friction noise and tremor from 1 Hz on with the least value, N rms; NaN as above, or
    where nothing strokes."""
    residual_high_n: float

    @property
    def swing(self) -> float:
        """How far Ms moves, infinite if the loop can become unstable."""
        apart = abs(self.peak_high - self.peak_low)
        return apart if math.isfinite(apart) else math.inf


def importance(found: Bench) -> list[Importance]:
    """Return the assumed numbers, the most important first; none if no gains hold on the bench.

    The gains are those of `retune` on the bench as described; then one number at a time takes the ends of its range,
    the controller knowing nothing of it.

    Parameters
    ----------
    found : Bench
        From ``fl.identify.bench``.
    """
    try:
        tuned = found.system.evolve(retune(operating_band(found.system)).overrides)
    except FrictionloopError:
        return []
    rows = []
    for path, factors in RANGES.items():
        if path in found.measured or path in found.stated:
            continue
        block, name = path.split(".")
        value = float(getattr(getattr(tuned, block), name))
        low, high = (value * factor for factor in factors)
        ends = [_judged(tuned, path, end) for end in (low, high)]
        rows.append(Importance(path, low, high, ends[0][0], ends[1][0], ends[0][1], ends[1][1]))
    return sorted(rows, key=lambda row: -row.swing)


def _judged(system: System, path: str, value: float) -> tuple[float, float]:
    """Return Ms and the residual in N rms with one value changed."""
    try:
        loop = linearise(system.evolve({path: value}))
    except FrictionloopError:
        return math.nan, math.nan  # the set-point is out of reach
    margins = loop.margins()
    return (margins.sensitivity_peak, _residual_n(loop)) if margins.stable else (math.inf, math.inf)


def _residual_n(loop: LinearLoop) -> float:
    """Return the rms of |S| times what moves the force behind the contact, sqrt(integral of |S|^2 |C|^2 P df)."""
    system = loop.system
    if not (isinstance(system.friction, FingerFriction) and isinstance(system.motion, Strokes)):
        return math.nan
    frequency = np.geomspace(1.0, loop.nyquist_hz, POINTS)
    lag = np.abs(linearise_contact(system, loop.elements.force_n).response(frequency))
    left = touch_spectrum(system, 0.0)(frequency) * (lag * np.abs(loop.responses(frequency)["S"])) ** 2
    return math.sqrt(float(np.trapezoid(left, frequency)))
