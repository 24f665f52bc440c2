"""What is felt: the residual weighted by the thresholds of touch, whose mean square is the index D squared.

Where nothing is scored (reversals, lift-offs) the residual is faded out, and in again, over some 20 ms: cut off, it
would click in the filter.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from frictionloop.loop.metric import Sample, Tally
from frictionloop.quantities.arithmetic import biquad_step, fma, step
from frictionloop.quantities.compiled import keep_compiled

FADE_S = 0.01
"""Time constant of each of the two low-passes that fade the residual (assumed)."""


class Section(NamedTuple):
    """A section of the weighting filter: its state and its coefficients."""

    s1: float
    s2: float
    b0: float
    b1: float
    b2: float
    a1: float
    a2: float


class Felt(NamedTuple):
    """The sum of squares, the fade with its gain per period, and the filter."""

    felt2: float
    gain: float
    fade_1: float
    fade_2: float
    first: Section
    second: Section
    third: Section
    fourth: Section
    fifth: Section


@step
def filtered(section: Section, x: float) -> tuple[Section, float]:
    """Return a section after a sample, and what comes out of it."""
    s1, s2, b0, b1, b2, a1, a2 = section
    s1, s2, y = biquad_step(s1, s2, x, b0, b1, b2, a1, a2)
    return Section(s1, s2, b0, b1, b2, a1, a2), y


@step
def feel(state: Felt, sample: Sample, dt: float) -> Felt:
    """Fade and filter the residual, and add its square."""
    felt2, gain, fade_1, fade_2, first, second, third, fourth, fifth = state
    fade_1 = fma(gain, sample.scored - fade_1, fade_1)
    fade_2 = fma(gain, fade_1 - fade_2, fade_2)
    first, x = filtered(first, (sample.f_a - sample.f_r) * fade_2)
    second, x = filtered(second, x)
    third, x = filtered(third, x)
    fourth, x = filtered(fourth, x)
    fifth, x = filtered(fifth, x)
    x *= sample.counts
    return Felt(fma(x, x, felt2), gain, fade_1, fade_2, first, second, third, fourth, fifth)


@step
def faded_and_filtered(gain: float, sos: Any, residual: Any, scored: Any, felt: Any) -> None:
    """Fade a residual where it is not scored, filter it by sections (sections, 6), and write it to ``felt``."""
    fade_1, fade_2 = 0.0, 0.0
    states = np.zeros((sos.shape[0], 2))
    for k in range(residual.size):
        fade_1 = fma(gain, scored[k] - fade_1, fade_1)
        fade_2 = fma(gain, fade_1 - fade_2, fade_2)
        x = residual[k] * fade_2
        for i in range(sos.shape[0]):
            b0, b1, b2, _, a1, a2 = sos[i]
            states[i, 0], states[i, 1], x = biquad_step(states[i, 0], states[i, 1], x, b0, b1, b2, a1, a2)
        felt[k] = x * scored[k]


keep_compiled(faded_and_filtered, "felt")


def fade_gain(rate_hz: float) -> float:
    """Return the gain per control period of each of the low-passes that fade."""
    return 1.0 - math.exp(-1.0 / (FADE_S * rate_hz))


def _start(setpoint: Any, rate_hz: float) -> Felt:
    from frictionloop.perception.weighting import weighting_sos  # half a second of scipy, not needed for every run

    sections = [Section(0.0, 0.0, b0, b1, b2, a1, a2) for b0, b1, b2, _, a1, a2 in weighting_sos(rate_hz).tolist()]
    return Felt(0.0, fade_gain(rate_hz), 0.0, 0.0, *sections)


FELT = Tally("felt", feel, Felt, _start, everywhere=True)
