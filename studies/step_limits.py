"""Step times no law should be expected to beat, of a whole population: references in closed form, and the optimum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from frictionloop.design.comparison.protocol import STEP_LEVELS_N
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError
from studies.extremes import undisturbed
from studies.step_reference import StepTimes, reference_times
from studies.time_optimal import time_optimal


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
    some = [each for each in own if each is not None]
    kept = np.array([each is not None for each in own])
    return StepLimits(
        _spread(reference_times(some, STEP_LEVELS_N), kept), _spread(time_optimal(some, STEP_LEVELS_N), kept)
    )


def _undisturbed(system: System, occluded: float) -> System | None:
    try:
        return undisturbed(system, occluded)
    except FrictionloopError:
        return None


def _spread(times: StepTimes, kept: np.ndarray) -> StepTimes:
    """Return the times of the fingers kept as arrays over all, NaN for the others."""
    table = np.full((len(times), kept.size), np.nan)
    table[:, kept] = times
    return StepTimes(*table)
