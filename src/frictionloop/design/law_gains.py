"""The gains of a law times a factor."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from frictionloop.design.corners import at_mean
from frictionloop.parameters import System
from frictionloop.parameters.summary import own_values
from frictionloop.quantities import FrictionloopError

ROUNDING = 2e-3
"""Share of a factor on gains that is left for rounding these to four digits."""
TRIED, SAME = 0.5, 1e-6
"""A factor that is tried on the fields of a law, and the share by which its response may miss it."""


def rounded(gain: float) -> float:
    """Return the largest gain that holds with four digits, rounded so that it holds."""
    return float(f"{(1.0 - ROUNDING) * gain:.4g}")


def scaled_gains(system: System, factor: float) -> Mapping[str, float]:
    """Return overrides with which the loop of a law has ``factor`` times its gain; empty where no fields scale it.

    The fields are found by trying: those by which the response of the law is in proportion, the fewest of them.
    """
    values = {name: value for name, value in own_values(system).items() if isinstance(value, float) and value}
    some = [name for name in values if name.startswith("k")]
    wholes = [each for size in range(1, len(some) + 1) for each in combinations(some, size)]
    for names in [*wholes, *((name,) for name in values if name not in some)]:
        if _scales(system, {f"controller.{name}": TRIED * values[name] for name in names}):
            less = {f"controller.{name}": rounded(factor * values[name]) for name in names}
            return less if any(less.values()) else {}
    return {}


def _scales(system: System, changes: Mapping[str, float]) -> bool:
    """Tell whether changes multiply the response of a law by `TRIED`."""
    frequency = np.geomspace(1.0, 0.4 * system.controller.rate_hz, 50)
    try:
        before, after = (at_mean(each).law.response(frequency)[:, 1, 1] for each in (system, system.evolve(changes)))
    except FrictionloopError:
        return False
    return bool(np.all(np.abs(after - TRIED * before) <= SAME * np.abs(before)) and np.any(before))
