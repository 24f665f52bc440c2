"""PI behind up to six biquads, the notch among them, with feed-forward of the set-point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from frictionloop.control.expected_reading import (
    ExpectedGains,
    ExpectedState,
    expected_gains,
    expected_start,
    expected_step,
)
from frictionloop.control.law import ForceCommand, Law, clamp_of
from frictionloop.control.notch import Section, notch_section
from frictionloop.parameters.controller import FILTERS
from frictionloop.quantities.scalar_math import biquad_step, fma, step
from frictionloop.sensing.measurement import Measurement


class Memory(NamedTuple):
    """Of a section."""

    s1: float
    s2: float


class FilteredState(NamedTuple):
    """Integral in N, what the sections remember, and what the sensor is expected to read."""

    integral: float
    memory_1: Memory
    memory_2: Memory
    memory_3: Memory
    memory_4: Memory
    memory_5: Memory
    memory_6: Memory
    expected: ExpectedState


class FilteredGains(NamedTuple):
    """kp (N/N), ki (1/s), what holds sections to the command, the sections, the expected reading, the clamp (N)."""

    kp: float
    ki: float
    hold: float
    section_1: Section
    section_2: Section
    section_3: Section
    section_4: Section
    section_5: Section
    section_6: Section
    expected: ExpectedGains
    low: float
    high: float


THROUGH = Section(1.0, 0.0, 0.0, 0.0, 0.0)
"""A section that is not there: its output is its input, to the bit."""
FREE = 2
"""Sections that the command does not hold: for what is fast or inverts the springs."""
LEAST_HELD = 1e-6
"""Least direct gain in N/N for which an error is computed that would give the command (assumed)."""


@step
def filtered_pi_step(
    state: FilteredState, measurement: Measurement, setpoint_n: float, gains: FilteredGains, dt: float
) -> tuple[FilteredState, ForceCommand]:
    """e = F(z) (f_ref - f_m), v = kp e + I, u = clip(s f_r + v): PI of `pi_step` on a filtered error.

    Without feed-forward f_ref = f_r and s = 0; with it f_ref is the reading that the model expects (`expected_step`)
    and s = 1: the set-point commands, and the PI corrects what the model does not know. No preview of the set-point.
    Without a sliding finger (``valid`` 0) the integral is held, u = clip(s f_r + I), and the filters are fed 0.

    Sections behind the first two are held to the command (Hanus, Kinnaert, Henrotte, Automatica 23, 1987): in front of
    them e gets (u - v)/(kp prod b0) more, the error for which they and the PI would have asked for just this u. Their
    memory and the integral are then those of the command in force, whatever the error was while the clamp acted or the
    finger did not slide, and sliding begins again at s f_r + I. The first two run free, because a section that inverts
    the springs would ring if it were held. Where nothing is held (`hold_gain`) the
    integral stops where e pushes v further into the clamp, as in `pi_step`.

    Every state is bounded: free sections by
    their gain times the largest error, held ones and the integral by what their inverse makes of a signal within the
    clamp, other integrals by conditional integration, and forces of the expected reading by set-point and clamp (the
    springs' overshoot at most doubles a step).
    """
    kp, ki, hold, first, second, third, fourth, fifth, sixth, believed, low, high = gains
    integral, m1, m2, m3, m4, m5, m6, expected = state
    force, _, _, _, valid = measurement
    feed = feeds_forward(gains)
    reference = expected.reading if feed > 0.5 else setpoint_n
    e = valid * (reference - force)
    m1, e = section_step(m1, e, first)
    m2, e = section_step(m2, e, second)
    y = fma(fourth.b0, fma(third.b0, e, m3.s1), m4.s1)
    y = fma(sixth.b0, fma(fifth.b0, y, m5.s1), m6.s1)
    # The PI has what the set-point leaves of the clamp.
    ahead = feed * setpoint_n
    v = fma(valid * kp, y, integral)
    within = min(max(v, low - ahead), high - ahead)
    e = fma(hold, within - fma(kp, y, integral), e)
    m3, e = section_step(m3, e, third)
    m4, e = section_step(m4, e, fourth)
    m5, e = section_step(m5, e, fifth)
    m6, e = section_step(m6, e, sixth)
    pushes = (hold == 0.0) & (((v > within) & (e > 0.0)) | ((v < within) & (e < 0.0)))
    integral = integral if pushes else fma(valid * ki * dt, e, integral)
    u = min(max(fma(feed, setpoint_n, within), low), high)
    expected = expected_step(expected, setpoint_n, low, high, believed)
    after = FilteredState(integral, m1, m2, m3, m4, m5, m6, expected)
    return after, ForceCommand(u, 1.0 if v != within else 0.0)


@step
def section_step(memory: Memory, x: float, section: Section) -> tuple[Memory, float]:
    """One section: `biquad_step`."""
    s1, s2 = memory
    b0, b1, b2, a1, a2 = section
    s1, s2, y = biquad_step(s1, s2, x, b0, b1, b2, a1, a2)
    return Memory(s1, s2), y


@step
def feeds_forward(gains: FilteredGains) -> float:
    """1 with feed-forward of the set-point, 0 without."""
    return 1.0 if gains.expected.whole > -0.5 else 0.0


@step
def filtered_pi_begin(state: FilteredState, force_n: float, setpoint_n: float, gains: FilteredGains) -> FilteredState:
    """I = u - s f_r: with feed-forward the set-point is ahead of the integral."""
    _, m1, m2, m3, m4, m5, m6, expected = state
    integral = force_n - setpoint_n if feeds_forward(gains) > 0.5 else force_n
    return FilteredState(integral, m1, m2, m3, m4, m5, m6, expected)


def hold_gain(kp: float, ki: float, sections: Sequence[Section], dt: float) -> float:
    """Return 1/(kp prod b0) over the sections behind the first two, or 0 where they cannot be held to the command.

    The inverse of PI and sections has to be stable: |b2/b0| < 1 and |b1/b0| < 1 + b2/b0 in each, ki dt <= kp.
    """
    held, gain = sections[FREE:], kp
    for b0, b1, b2, _, _ in held:
        if not (abs(b2) < abs(b0) and abs(b1) < abs(b0 + b2)):
            return 0.0
        gain *= b0
    return 1.0 / gain if held and ki * dt <= kp and abs(gain) > LEAST_HELD else 0.0


def sections_of(controller: Any) -> tuple[Section, ...]:
    """Return the sections of a controller: its own, or its notch's one."""
    if controller.kind == "notch_pi":
        notch = (controller.notch_hz, controller.notch_depth, controller.notch_width)
        return (notch_section(*notch, controller.rate_hz),)
    return tuple(Section(*each) for each in controller.sections)


def filtered_pi_gains(controller: Any) -> FilteredGains:
    """Return the gains of `filtered_pi_step`, for both kinds of parameters."""
    sections = sections_of(controller)
    first, second, third, fourth, fifth, sixth = sections + (THROUGH,) * (FILTERS - len(sections))
    hold = hold_gain(controller.kp, controller.ki, sections, 1.0 / controller.rate_hz)
    padded = first, second, third, fourth, fifth, sixth
    return FilteredGains(
        controller.kp, controller.ki, hold, *padded, expected_gains(controller), *clamp_of(controller.model)
    )


def filtered_pi_start(controller: Any) -> FilteredState:
    """Return the state at t = 0: at rest, with the expected reading settled on the believed f0."""
    empty = Memory(0.0, 0.0)
    return FilteredState(0.0, empty, empty, empty, empty, empty, empty, expected_start(controller))


FILTERED_PI_LAW = Law(
    "filtered_pi",
    filtered_pi_step,
    FilteredState,
    FilteredGains,
    filtered_pi_gains,
    filtered_pi_start,
    begin=filtered_pi_begin,
)
