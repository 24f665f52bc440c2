"""Step times no law should be expected to beat, of a whole population: references in closed form, and the optimum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from frictionloop.design.tournament.extremes import undisturbed
from frictionloop.design.tournament.optimal import time_optimal
from frictionloop.design.tournament.protocol import STEP_LEVELS_N
from frictionloop.design.tournament.reference import StepTimes, reference_times
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError


class StepLimits(NamedTuple):
    """What step times are divided by, arrays over fingers."""

    reference: StepTimes
    """The springs of the skin on the way up, the drive on the way down: what figures are stated against."""
    bound: StepTimes
    """The shortest under any drive that does not turn back on its way."""


def step_limits(system: System, people: Sequence[Mapping[str, Any]], occluded: float = 0.0) -> StepLimits:
    """Return both for each finger on a bench, at its mean load and so far occluded, undisturbed.

    Parameters
    ----------
    system
        A bench with skin and contact, at one speed; ``controller.delay_s`` is the dead time of its loop.
    people
        Fingers as overrides.
    occluded
        How far occlusion has come, 0 to 1.

    Returns
    -------
    StepLimits
        NaN for a finger that has not got the levels, or is too light for a law to act.
    """
    own = [_undisturbed(system.evolve(each), occluded) for each in people]
    found = [i for i, each in enumerate(own) if each is not None]
    some = [each for each in own if each is not None]
    reference = [reference_times(each, STEP_LEVELS_N) for each in some]
    bound = time_optimal(some, STEP_LEVELS_N) if some else []
    return StepLimits(_spread(reference, found, len(own)), _spread(np.transpose(bound), found, len(own)))


def _undisturbed(system: System, occluded: float) -> System | None:
    try:
        return undisturbed(system, occluded)
    except FrictionloopError:
        return None


def _spread(rows: Any, where: list[int], count: int) -> StepTimes:
    """Return rows of times as arrays over all fingers, NaN for those without a row."""
    table = np.full((count, len(StepTimes._fields)), np.nan)
    table[where] = np.reshape(rows, (len(where), len(StepTimes._fields)))
    return StepTimes(*table.T)
