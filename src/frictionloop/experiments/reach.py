"""What a participant's own finger can be given: measured by plain strokes before and after a session."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from frictionloop.loop.simulate import traced
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError

STROKE_S = 1.5
"""Duration of a plain stroke (assumed: that of a trial's)."""


class Reach(NamedTuple):
    """Friction of one finger without vibration and with the largest one."""

    highest_n: float
    lowest_n: float
    susceptibility_per_um2: float
    """tau of g(a) = f0 exp(-tau a^2) through the two."""

    @property
    def changes(self) -> dict[str, Any]:
        """What the controller believes of this finger, by dotted name."""
        return {
            "controller.model.nominal_n": self.highest_n,
            "controller.model.susceptibility_per_um2": self.susceptibility_per_um2,
        }


def simulated_reach(system: System, seed: int = 0) -> Reach:
    """Return the reach of a simulated finger: mean forces of two strokes, without vibration and with the largest.

    Parameters
    ----------
    system : System
        Bench and finger.
    seed : int
        Seed of the strokes' noise.

    Raises
    ------
    FrictionloopError
        For a finger whose friction does not fall with vibration.
    """
    most = system.plate.max_amplitude_um
    without, largest = (_mean_n(system, seed, amplitude) for amplitude in (0.0, most))
    return reach_of(without, largest, most)


def _mean_n(system: System, seed: int, amplitude_um: float) -> float:
    (run,) = traced([system], [seed], STROKE_S, amplitude_um)
    return float(np.mean(run["f_a"].values[run["scored"].values]))


def reach_of(highest_n: float, lowest_n: float, max_amplitude_um: float) -> Reach:
    """Return the reach from the two forces, N, and the largest amplitude, um."""
    if not 0.0 < lowest_n < highest_n:
        raise FrictionloopError(
            f"reach: {highest_n:.3g} N without vibration, {lowest_n:.3g} N with it; the second must be less"
        )
    return Reach(highest_n, lowest_n, math.log(highest_n / lowest_n) / max_amplitude_um**2)
