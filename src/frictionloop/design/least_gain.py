"""The factor on the gain of many loops up to which all keep their limits, found on one grid of frequencies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from frictionloop.analysis.linear import LinearLoop
from frictionloop.analysis.margins import gain_roots
from frictionloop.analysis.state_space import Array, Complex, StateSpace
from frictionloop.design.plants import Plants

NEAR = 1.02
"""Factors above the least of a coarse grid by less than this are looked at closely: the grid is right within 1 %."""


def least_gain(loops: Sequence[LinearLoop], limits: Sequence[float], plants: Plants | None = None) -> float:
    """Return the least `LinearLoop.gain_factor` of loops with their laws, each with its largest Ms.

    ``plants`` are the loops on a coarse grid where they are known already.
    """
    there = plants or Plants.of(loops, fine=False)
    gains = laws_on(there.frequency_hz, loops) * there.responses
    rough = np.min(gain_roots(gains, np.array(limits)[:, None]), axis=1)
    least = float(np.min(rough))
    near = [k for k, factor in enumerate(rough.tolist()) if factor <= NEAR * least]
    return min(loops[k].gain_factor(limits[k]) for k in near)


def laws_on(frequency_hz: Array, loops: Sequence[LinearLoop]) -> Complex:
    """Return the response of each law from minus the measured force to its command, shape (loops, frequencies)."""
    laws: dict[int, StateSpace] = {id(loop.law): loop.law for loop in loops}  # most loops share theirs
    found = {name: -law.response(frequency_hz)[:, 1, 1] for name, law in laws.items()}
    return np.array([found[id(loop.law)] for loop in loops])
