"""The loop gain that other people bring, and the gains of a law times a factor."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from frictionloop.analysis.operating import force_band, law_at, occlusions
from frictionloop.design.corners import at_mean, cases_of
from frictionloop.design.operating_grid import Lean, OperatingGrid
from frictionloop.design.plants import least_gain
from frictionloop.parameters import FingerFriction, Skin, Strokes, System
from frictionloop.parameters.summary import own_values
from frictionloop.physics.fingers import fingers
from frictionloop.physics.friction import is_gaussian
from frictionloop.quantities import FrictionloopError

MOST_PEAK = 2.9
"""Ms above which a loop is said to come close to ringing: it returns a distance of 1/2.9 from -1 (assumed)."""
MANY = 0.02
"""Share of people from which on another law is worth it (assumed)."""
COUNT, SEED = 1000, 0
"""Fingers that are drawn where nobody brings a population."""


class LoopGains(NamedTuple):
    """How many people are close to ringing."""

    share: float
    """Of the people, 0 to 1."""
    critical: float
    """Loop gain over the believed one from which on Ms is above `MOST_PEAK`."""
    people: int
    median: float
    """Loop gain of the people, median and worst percentile."""
    highest: float

    @property
    def many(self) -> bool:
        """Whether it is more than `MANY` of them."""
        return self.share > MANY


def loop_gain(system: System) -> float:
    """Return the largest loop gain of a finger over that of the believed one, NaN where no force asked for is in reach.

        (dF/da)/(du/da) = (F/u) (tau/tau_model), u the command at which F is reached

    over lowest, mean and highest force asked for, just landed and moist. Where one is out of reach the command stays at
    its limit, and nothing can ring. A law that commands a logarithm sees tau over that of the model.
    """
    model, margin, found = system.controller.model, getattr(system.controller, "susceptibility_margin", None), []
    largest_um = min(system.plate.max_amplitude_um, model.max_amplitude_um)
    for occluded in occlusions(system):
        law: Any = law_at(system, occluded)
        tau, most = law.susceptibility_per_um2, largest_um * largest_um
        for force_n in force_band(system):
            square = math.log(law.nominal_n / force_n) / tau if force_n > 0.0 else math.inf
            if 0.0 <= square <= most:
                command_n = model.nominal_n * math.exp(-model.susceptibility_per_um2 * square)
                gain = 1.0 if margin else force_n / command_n
                found.append(gain * tau / model.susceptibility_per_um2)
    return max(found, default=math.nan)


def critical_gain(system: System, grid: OperatingGrid) -> float:
    """Return the loop gain over the believed one up to which Ms is at most `MOST_PEAK`, the resonance as told."""
    cases = cases_of(system, grid._replace(limits={0.0: MOST_PEAK}, lean=Lean()))
    return loop_gain(system) * least_gain([loop for loop, _, _ in cases], [MOST_PEAK] * len(cases))


def loop_gains(
    system: System, grid: OperatingGrid, people: Sequence[Mapping[str, Any]] | None = None
) -> LoopGains | None:
    """Return on how many people the controller of a System has an Ms above `MOST_PEAK`; None without a law in reach.

    A person's loop differs from the file's by its gain; contact and speed are those of ``over``.

    Parameters
    ----------
    system
        The bench with its controller.
    over
        Contacts and speeds to look at.
    people
        Overrides, one finger each; `COUNT` assumed ones if not given.
    """
    moves = isinstance(system.finger, Skin) and isinstance(system.motion, Strokes)
    if (
        not (moves and isinstance(system.friction, FingerFriction))
        or not is_gaussian(system.friction)
        or system.controller.kind == "lookup"
    ):
        return None
    some = fingers(COUNT, SEED) if people is None else people
    gains = np.array([loop_gain(system.evolve(dict(each))) for each in some])
    critical = critical_gain(system, grid)
    if math.isnan(critical) or np.all(np.isnan(gains)):
        return None
    share = float(np.mean(gains > critical))
    return LoopGains(share, critical, len(gains), float(np.nanmedian(gains)), float(np.nanpercentile(gains, 99)))


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
