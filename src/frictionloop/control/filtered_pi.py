"""PI behind up to six biquads, the notch among them, with feed-forward of the set-point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from frictionloop.control.expected import (
    ExpectedGains,
    ExpectedState,
    expected_gains,
    expected_start,
    expected_step,
)
from frictionloop.control.law import ForceCommand
from frictionloop.control.notch import Section, notch_section
from frictionloop.parameters.filtered import FILTERS
from frictionloop.quantities.arithmetic import fma, step
from frictionloop.quantities.biquad import biquad_step
from frictionloop.sensing.measurement import Measurement

STATES = 1 + 2 * FILTERS + len(ExpectedState._fields)
"""Integral, two of each section, the expected reading."""
GAINS = 3 + 5 * FILTERS + len(ExpectedGains._fields)
"""kp, ki, what holds sections to the command, the sections, the expected reading; the clamp follows."""
THROUGH: Section = (1.0, 0.0, 0.0, 0.0, 0.0)
"""A section that is not there: its output is its input, to the bit."""
FREE = 2
"""Sections that the command does not hold: for what is fast or inverts the springs."""
LEAST_HELD = 1e-6
"""Least direct gain in N/N for which an error is computed that would give the command (assumed)."""


@step
def filtered_pi_step(
    state: tuple[float, ...], measurement: Measurement, setpoint_n: float, gains: tuple[float, ...], dt: float
) -> tuple[tuple[float, ...], ForceCommand]:
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
    kp, ki, hold = gains[0], gains[1], gains[2]
    low, high = gains[46], gains[47]
    force, _, _, _, valid = measurement
    integral, expected = state[0], state[13:21]
    feed = 1.0 if gains[34] > -0.5 else 0.0
    reference = expected[7] if feed > 0.5 else setpoint_n
    e = valid * (reference - force)
    s1, s2, e = biquad_step(state[1], state[2], e, *gains[3:8])
    s3, s4, e = biquad_step(state[3], state[4], e, *gains[8:13])
    y = fma(gains[18], fma(gains[13], e, state[5]), state[7])
    y = fma(gains[28], fma(gains[23], y, state[9]), state[11])
    # The PI has what the set-point leaves of the clamp.
    ahead = feed * setpoint_n
    v = fma(valid * kp, y, integral)
    within = min(max(v, low - ahead), high - ahead)
    e = fma(hold, within - fma(kp, y, integral), e)
    s5, s6, e = biquad_step(state[5], state[6], e, *gains[13:18])
    s7, s8, e = biquad_step(state[7], state[8], e, *gains[18:23])
    s9, s10, e = biquad_step(state[9], state[10], e, *gains[23:28])
    s11, s12, e = biquad_step(state[11], state[12], e, *gains[28:33])
    pushes = (hold == 0.0) & (((v > within) & (e > 0.0)) | ((v < within) & (e < 0.0)))
    integral = integral if pushes else fma(valid * ki * dt, e, integral)
    u = min(max(fma(feed, setpoint_n, within), low), high)
    c1, c2, c3, driven, plate, spring, rate, reading = expected_step(expected, setpoint_n, low, high, gains[33:46])
    sections = (s1, s2, s3, s4, s5, s6, s7, s8, s9, s10, s11, s12)
    after = (integral, *sections, c1, c2, c3, driven, plate, spring, rate, reading)
    return after, ForceCommand(u, 1.0 if v != within else 0.0)


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
    return tuple(controller.sections)


def filtered_pi_gains(controller: Any) -> tuple[float, ...]:
    """Return the gains of `filtered_pi_step` without the clamp, for both kinds of parameters."""
    sections = sections_of(controller)
    padded = sections + (THROUGH,) * (FILTERS - len(sections))
    coefficients = [number for section in padded for number in section]
    hold = hold_gain(controller.kp, controller.ki, sections, 1.0 / controller.rate_hz)
    return (controller.kp, controller.ki, hold, *coefficients, *expected_gains(controller))


def filtered_pi_start(controller: Any) -> tuple[float, ...]:
    """Return the state at t = 0: at rest, with the expected reading settled on the believed f0."""
    return (*[0.0] * (1 + 2 * FILTERS), *expected_start(controller))
