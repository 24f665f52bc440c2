"""Binary places for the sections of the filtered PI in the firmware: as many as fit what can ever be in them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.signal import sosfilt

from frictionloop.control.filtered_pi import FREE
from frictionloop.control.notch import Section
from frictionloop.quantities import must_be

LARGEST_N = 8.0
"""Forces and their differences in the firmware are within this: 2^31 steps of 2^-28 N."""
MOST_PLACES = 40
"""Of a quiet section (assumed: far beyond what a force within 0.2 mN needs)."""
LONGEST = 1 << 20
"""Control periods over which an impulse response is summed at most (assumed)."""
_TAIL = 1e-3
"""Share of an impulse response that is left when the sum ends; `_MARGIN` covers it and rounding."""
_MARGIN = 1.02


class Sizes(NamedTuple):
    """Largest magnitudes in the filter, N."""

    sections: tuple[float, ...]
    """Of each section: outputs, memories and products."""
    output: float
    """Behind all sections, as the PI would first see it."""


def section_sizes(sections: Sequence[Section], kp: float, held: bool) -> Sizes:
    """Bound what sections can hold, for errors and forces within 8 N.

    A free section gives at most the sum of |h| of all up to it times the largest error. Held ones are what the inverse
    of PI and sections makes of a command within the clamp: y = (u - I)/kp behind the last, and so back through each
    inverse. Before the command is clipped, the PI sees b0 of each and its memory.
    """
    outputs = _chain(sections[:FREE] if held else sections)
    if held:
        behind = 2.0 * LARGEST_N / kp
        first, *inputs = _before_held(sections[FREE:], behind)
        outputs = [*outputs[:-1], max(outputs[-1], first), *inputs, behind]
    sizes, first, before = [], LARGEST_N, LARGEST_N
    for i, (section, after) in enumerate(zip(sections, outputs, strict=True)):
        b0, b1, b2, a1, a2 = map(abs, section)
        memory = after + b0 * before
        trial = b0 * first + memory if held and i >= FREE else after
        sizes.append(max(after, trial, memory, b1 * before, a1 * after, b2 * before + a2 * after))
        first, before = trial, after
    return Sizes(tuple(sizes), first)


def places_for(size: float, most: int = MOST_PLACES) -> int:
    """Return the most binary places with which 32 bits hold a magnitude."""
    return min(math.floor(31.0 - math.log2(max(size * _MARGIN, 2.0**-most))), most)


def _before_held(sections: Sequence[Section], behind: float) -> list[float]:
    """Return the largest input of each held section, given the largest output of the last."""
    inverses = [Section(1.0, a1, a2, b1 / b0, b2 / b0) for b0, b1, b2, a1, a2 in reversed(sections)]
    inputs, gain = [], behind / LARGEST_N
    for section, total in zip(reversed(sections), _chain(inverses), strict=True):
        gain /= abs(section[0])
        inputs.append(total * gain)
    return inputs[::-1]


def _chain(sections: Sequence[Section]) -> list[float]:
    """Return 8 N times the sum of |h| of the first section, of the first two, and so on."""
    if not sections:
        return []
    impulse = np.zeros(_length(sections))
    impulse[0] = LARGEST_N
    sums = []
    for b0, b1, b2, a1, a2 in sections:
        impulse = sosfilt([[b0, b1, b2, 1.0, a1, a2]], impulse)
        sums.append(float(np.sum(np.abs(impulse))))
    return sums


def _length(sections: Sequence[Section]) -> int:
    """Return after how many periods little is left of an impulse."""
    radius = max(float(np.max(np.abs(np.roots((1.0, a1, a2))), initial=0.0)) for *_, a1, a2 in sections)
    if radius >= 1.0 or (periods := _forgotten(radius, len(sections))) > LONGEST:
        raise must_be("controller.sections: radius", float(radius), f"forgotten in {LONGEST} periods")
    return periods


def _forgotten(radius: float, count: int) -> int:
    """Return n with n^(2 count) radius^n below the tail: poles may coincide."""
    if radius < 1e-3:
        return 64
    decay = -math.log(radius)
    n = 64.0 + 1.0 / decay
    for _ in range(50):
        n = max(n, (2 * count * math.log(max(n * decay, 1.0)) - math.log(_TAIL * 1e-2)) / decay)
    return math.ceil(n)
