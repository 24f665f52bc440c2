"""The shortest times of a step that a drive can give which does not turn back: the true plant under extreme commands.

To 63 %: the command goes to its end as soon as the loop can act, and stays. From 10 to 90 %: the same, from the old
level or from rest at 10 %, whichever is shorter. docs/controllers says what of this is a theorem, and what a
search has not found to be wrong.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from frictionloop.parameters import Skin, Strokes, System
from frictionloop.physics.friction import amplitude_for
from studies.extremes import forces_from_rest
from studies.step_reference import SHARE_10, SHARE_63, SHARE_90, StepTimes, skin_time_s

PLATE_TIMES, BRISTLE_TIMES, SKIN_TIMES = 10.0, 10.0, 3.0
"""How many times of plate, bristle and skin a step is followed (assumed: what has not come by then does not)."""
Pair = tuple[np.ndarray, np.ndarray]
"""Times in s to 63 % and from 10 to 90 %, each of shape (fingers,)."""


def time_optimal(systems: Sequence[System], levels_n: tuple[float, float]) -> StepTimes:
    """Return the shortest times of the steps between two levels, arrays over fingers, NaN where one is out of reach.

    Parameters
    ----------
    systems
        Bench and finger each, `extremes.undisturbed`, of equal structure.
    levels_n
        The low and the high level, N.
    """
    low, high = levels_n
    rises, falls = np.full((2, len(systems)), np.nan), np.full((2, len(systems)), np.nan)
    for found, start, stop in ((rises, low, high), (falls, high, low)):
        able = [i for i, each in enumerate(systems) if _has(each, start)]
        if able:
            some = [systems[i] for i in able]
            found[:, able] = _driven(some, start, stop)
    return StepTimes(*rises, *falls)


def passage_s(forces_n: np.ndarray, period_s: float, level_n: float) -> np.ndarray:
    """Return when forces (times, fingers) first pass a level, on a line between two; NaN for those that never do."""
    gone = (forces_n - level_n) * np.sign(level_n - forces_n[0])
    passed = gone >= 0.0
    k = np.maximum(np.argmax(passed, axis=0), 1)
    before, after = (np.take_along_axis(gone, at[None], axis=0)[0] for at in (k - 1, k))
    crossed = passed.any(axis=0)
    return np.where(crossed, period_s * (k - 1 + before / np.where(crossed, before - after, 1.0)), np.nan)


def _driven(systems: Sequence[System], from_n: float, to_n: float) -> Pair:
    """Return the times under the extreme command: a monotone drive's shortest (docs/controllers)."""
    end_um = 0.0 if to_n > from_n else systems[0].plate.max_amplitude_um
    at_10, at_63, at_90 = (from_n + share * (to_n - from_n) for share in (SHARE_10, SHARE_63, SHARE_90))
    duration_s, delay_s = _followed_s(systems, from_n, to_n), systems[0].controller.delay_s
    forces, period_s = forces_from_rest(systems, from_n, end_um, duration_s)
    times = [passage_s(forces, period_s, level) for level in (at_10, at_63, at_90)]
    whole = times[2] - times[0]
    led = [i for i, each in enumerate(systems) if _has(each, at_10)]
    if led:
        forces, period_s = forces_from_rest([systems[i] for i in led], at_10, end_um, duration_s)
        whole[led] = np.fmin(whole[led], passage_s(forces, period_s, at_90) - delay_s)
    return times[1], whole


def _followed_s(systems: Sequence[System], from_n: float, to_n: float) -> float:
    """Return how long a step is followed, within what is left of the stroke."""
    motion, finger = systems[0].motion, systems[0].finger
    assert isinstance(motion, Strokes)
    found = systems[0].controller.delay_s + PLATE_TIMES / (2.0 * np.pi * systems[0].plate.cutoff_hz)
    if isinstance(finger, Skin):
        bristle_s = 1e-3 * finger.slip_length_um / motion.speed_mm_s
        rises = to_n > from_n
        found += SKIN_TIMES * float(np.max(_skin_s(systems, to_n - from_n))) if rises else BRISTLE_TIMES * bristle_s
    return float(min(found, 0.45 * motion.plateau_s))


def _skin_s(systems: Sequence[System], way_n: float) -> np.ndarray:
    skins = [each.finger for each in systems if isinstance(each.finger, Skin)]
    speed_mm_s = systems[0].motion.speed_mm_s  # type: ignore[union-attr]
    return np.array([skin_time_s(way_n, each, speed_mm_s) for each in skins])


def _has(system: System, level_n: float) -> bool:
    """Return whether a finger has a level, at some amplitude of the plate's."""
    return bool(amplitude_for(level_n, system.friction) <= system.plate.max_amplitude_um)
