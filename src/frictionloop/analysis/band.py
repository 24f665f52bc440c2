"""The operating points at which one set of gains has to hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frictionloop.analysis.linear import LinearLoop, linearise
from frictionloop.analysis.operating import asked, law_at, reach_n
from frictionloop.findings import Condition
from frictionloop.parameters import FingerFriction, Skin, Strokes, System, check_system
from frictionloop.quantities import FrictionloopError


def condition_of(system: System) -> Condition:
    """Return at which slip length, speed and load a loop is linearised."""
    finger, motion = system.finger, system.motion
    found = Condition(slip_length_um=finger.slip_length_um if isinstance(finger, Skin) else None)
    return replace(found, speed_mm_s=motion.speed_mm_s, load_n=motion.load_n) if isinstance(motion, Strokes) else found


def operating_band(
    system: System, forces_n: Sequence[float] | None = None, occluded: Sequence[float] = (0.0,)
) -> list[LinearLoop]:
    """Return the loop at every force of a band, for every state of the finger.

    Parameters
    ----------
    system
        The loop.
    forces_n
        Friction forces g(a), N; by default the lowest, the mean and the highest of set-point less disturbance. One out
        of reach counts as the nearest that can be reached, where the loop then stays.
    occluded
        States of occlusion, 0 (just landed, where ``friction.nominal_n`` holds) to 1 (after long contact); without a
        `FingerFriction` they are all alike.

    Raises
    ------
    FrictionloopError
        No force or no state, or one that is not a number or out of range.
    """
    check_system(system)
    forces = np.asarray(asked(system) if forces_n is None else forces_n, dtype=float)
    states = tuple(occluded) if isinstance(system.friction, FingerFriction) else (0.0,)
    if not (forces.size and states and np.all(np.isfinite(forces))):
        raise FrictionloopError(
            f"forces_n = {forces.tolist()} N, occluded = {list(states)}: needs numbers, one at least"
        )
    points = {(float(force), w) for w in states for force in np.clip(forces, *reach_n(system, law_at(system, w)))}
    return [linearise(system, force_n=force, occluded=w) for force, w in sorted(points)]
