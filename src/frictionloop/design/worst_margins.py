"""Margins of the loops, of many, that are nearest to instability: in gain, in phase, in delay and in Ms."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from frictionloop.analysis.margins import Margins
from frictionloop.analysis.state_space import Array, Complex
from frictionloop.design.corners import Corner
from frictionloop.design.least_gain import laws_on
from frictionloop.design.plants import Plants
from frictionloop.loop.progress import step

Group = tuple[float, float]
"""Share by which the resonance is off, and how far occlusion has come."""


def worst_margins(found: Sequence[Corner]) -> dict[Group, list[Margins]]:
    """Return the margins of the worst loops of each resonance and finger: the least of each margin is among them.

    A grid of frequencies that all loops share tells which loops these are, where they differ by more than a percent;
    their margins are exact.
    """
    loops = [each.loop for each in found]
    step(f"margins of {len(loops)} loops")
    plants = Plants.of(loops, fine=False)
    gains = laws_on(plants.frequency_hz, loops) * plants.responses
    rough = np.array([_rough(plants.frequency_hz, gain) for gain in gains])
    rough = np.column_stack([rough, [1.0 / each.sensitivity_peak for each in found]])
    groups: dict[Group, list[int]] = {}
    for k, each in enumerate(found):
        groups.setdefault((each.off, each.loop.elements.occluded), []).append(k)
    picked = {at: dict.fromkeys(group[k] for k in np.argmin(rough[group], axis=0)) for at, group in groups.items()}
    return {at: [loops[k].margins() for k in some] for at, some in picked.items()}


def _rough(frequency_hz: Array, gain: Complex) -> tuple[float, float, float]:
    """Return how near G comes to -1 in gain (|ln|), in phase (rad) and in delay (s), straight between frequencies."""
    frequency, at_unity = _between(frequency_hz, gain, np.abs(gain) - 1.0)
    phase = np.angle(-at_unity)
    delay_s = np.mod(phase, 2.0 * np.pi) / (2.0 * np.pi * np.maximum(frequency, np.finfo(float).tiny))
    _, real = _between(frequency_hz, gain, gain.imag)
    negative = np.append(real.real, gain[-1].real)  # real at half the control rate
    negative = negative[negative < 0.0]
    least = [np.abs(np.log(-negative)), np.abs(phase), delay_s]
    ends = [float(np.min(each)) if each.size else math.inf for each in least]
    return ends[0], ends[1], ends[2]


def _between(frequency_hz: Array, gain: Complex, value: Array) -> tuple[Array, Complex]:
    """Return frequencies and G where a real value along it changes its sign."""
    k = np.flatnonzero((value[1:] >= 0.0) != (value[:-1] >= 0.0))
    share = value[k] / (value[k] - value[k + 1])
    return frequency_hz[k] + share * (frequency_hz[k + 1] - frequency_hz[k]), gain[k] + share * (gain[k + 1] - gain[k])
