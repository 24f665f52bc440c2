"""How much each number that nobody has measured matters to the loop: its margins over the range of that number."""

from __future__ import annotations

import math
from typing import NamedTuple

from frictionloop.analysis import linearise, operating_band
from frictionloop.design import retune
from frictionloop.identification import Bench
from frictionloop.parameters import System
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


class Importance(NamedTuple):
    """What one assumed number does to the loop."""

    path: str
    low: float
    """Least value that it may have."""
    high: float
    peak_low: float
    """Largest sensitivity Ms with the least value; infinite if unstable, NaN if the set-point is out of reach."""
    peak_high: float

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
        rows.append(Importance(path, low, high, _peak(tuned, path, low), _peak(tuned, path, high)))
    return sorted(rows, key=lambda row: -row.swing)


def _peak(system: System, path: str, value: float) -> float:
    try:
        margins = linearise(system.evolve({path: value})).margins()
    except FrictionloopError:
        return math.nan  # the set-point is out of reach
    return margins.sensitivity_peak if margins.stable else math.inf
