"""What made a run's force no number: a friction law from outside, or the control law."""

from __future__ import annotations

import math

import numpy as np

from frictionloop.loop.kernel.loop import Tile
from frictionloop.parameters import System
from frictionloop.physics.vibration import GAUSSIAN, vibration_of
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.blame import place

PLACES = 101
"""Amplitudes at which a friction law is looked at, from 0 to the plate's largest."""


def lanes_without_number(tile: Tile) -> np.ndarray:
    """Return which lanes of a tile that has run are left with a reading or a command that is no number.

    What gets into the sensor stays there: the last period tells of all.
    """
    rows = [tile.slab.view("u"), tile.slab.view("measurement")[:1], tile.slab.view("suspension")]
    return np.flatnonzero(np.isnan(np.concatenate(rows)).any(axis=0))


def no_number(system: System, where: str) -> FrictionloopError:
    """Return the error of a run whose force is no number; ``where`` is a time, or the point of a sweep."""
    friction, c = system.friction, system.controller
    law = vibration_of(friction)
    if law is not GAUSSIAN:
        given = law.coefficients_of(friction)
        for a in np.linspace(0.0, system.plate.max_amplitude_um, PLACES).tolist():
            for occluded in (0.0, 1.0):
                share = float(law.step(a, occluded, given))
                if math.isnan(share) or share < 0.0:
                    return FrictionloopError(
                        f'friction law "{friction.kind}": {place(law.step)}: step returned {share:g} at {a:g} um '
                        f"(occluded {occluded:g}) {where}; must be from 0 to 1"
                    )
    return FrictionloopError(f'law "{c.kind}": its force command is not a number {where}')
