"""The tracker: which amplitude gives the wanted friction, by an observer that learns the finger while it slides.

One law for any contact, speed and load. It observes the logarithm of the friction limit, in which fingers differ by an
offset, load and vibration add up, and the loop gain is the same for all (control/limit_observer). By the correlation
of innovations with their sensitivities (a recursive prediction error method, Ljung, System Identification, ch. 11) it
learns the compliance of the contact, on which the pole between limit and friction depends, and the susceptibility.
Gains are scheduled by that pole, which moves with speed and force.

Commands: the amplitude at which friction goes the given share of its error in a period, reached by overdrive; none at
all until friction that is on its way up has all but arrived. While a finger is stuck, lands or is lifted the limit is
held, and the law goes on from it without a jump. There is no integrator to wind up; the estimates are bounded.
"""

from __future__ import annotations

import math

from frictionloop.control.law import ForceCommand, Law
from frictionloop.control.limit_observer import (
    limit_of,
    place_of,
    scheduled,
    sensitivity_step,
    sensor_step,
    share_of,
    stuck_share,
)
from frictionloop.control.lookup import OverdriveGains, overdrive_step
from frictionloop.control.tracker_gains import tracker_gains, tracker_start
from frictionloop.control.tracker_state import ESTIMATES, TrackerState, TrackerTick
from frictionloop.quantities.arithmetic import exp2, fma, log2, step
from frictionloop.sensing.measurement import Measurement

LOG2_E = 1.4426950408889634
HALF_LN_2 = 0.34657359027997264
LOWEST, HIGHEST = -3.3, 5.0
"""Bounds of log2 of the limit: 0.1 to 32 N (assumed).

Believed 1.75 times as susceptible as it is, a moist finger of 3.4 N looks like one of 12 N.
"""
LARGEST_N = 5.0
"""Bound of the believed friction: twice what the sensor reads (a reading that jumps moves it by 17 times as much)."""
LARGEST_UP = 0.4
"""Most that one reading may move the logarithm of the limit: well below 1, as the limit itself follows it in a line."""
FASTEST_C, FASTEST_FALL = 2.0, 2e-4
"""Most that one reading may move compliance (um/N) and susceptibility (assumed: their ranges in 8 ms and 1.4 s)."""
LARGEST_BY_C, LARGEST_BY_T = 0.02, 4.0
"""Sensitivities of the reading, N per um/N and N um^2, at which they begin anew: while a tip sticks they grow."""
LEAN, LEAST_LEAN, LEAN_M_S = 120.0, 0.2, 0.02
"""Over what compliance times speed squared a step up of the compliance counts in full, per um/N (m/s)^2; the least
that it counts; and the least speed that is taken. Innovations of robust gains are coloured, and by them a slow slider
would be taken for a contact of 5 to 15 um/N; those of a true compliance point one way (chosen on fingers(400, 3))."""
SHORT_N = 0.03
"""Distance below the set-point above which vibration, once off, stays off (chosen likewise)."""
MOST_ADDED = 1.0
"""Most that a period adds to the sensitivity of friction, N per um/N: at a turn it has no bound, and begins anew."""
SLOWEST_M_S = 0.002
"""Speed below which the contact's time constant no longer grows (the least that counts as sliding)."""
SMOOTH, QUICK, SMOOTH_FALLS = 0.1, 0.5, 0.02
"""Gains of the smoothed rate of friction, of one that passes ringing at 350 Hz and lessens what single readings move it
by, and of the excess of the falls in that (assumed: 2, 0.3 and 10 ms)."""
RINGING_SHARE, RINGING_N_M_S2, CALMED_C = 0.25, 0.05, 20.0
"""Mean excess of falls that is ringing: above this share of the skin's rate and, times the speed, this; and the
compliance down to which it is taken off then, from which either contact is found. At 10 and 20 mm/s that is 5 N/s: at
20 a slider that is taken for a bristle has 6 to 14, what is known rightly below 2 (fingers(240, 3))."""
CALM_C, CALM_T = 2e-3, 1e-3
"""Shares by which compliance falls and susceptibility rises in a tick of ringing (chosen on fingers(300, 3))."""
FORGET = 4e-4
"""Gain of the mean squares of the sensitivities (assumed: half a second)."""
LEAP_N, LEAP_SHARE = 0.15, 0.9
"""Error of friction beyond which it leaps, and the share of the model's susceptibility that is then believed: less than
all of it, so that a leap rather goes too far than falls short (chosen on fingers(270, 3))."""
LEAP_TICK = 1.0 / 16.0
"""By how much less of a leap downwards is on its way through the sensor a tick later (chosen: 3 ms in all)."""


@step
def tracker_step(
    state: TrackerState, measurement: Measurement, setpoint_n: float, gains: TrackerTick, dt: float
) -> tuple[TrackerState, ForceCommand]:
    """One tick; see the module."""
    (
        a, command, d, trusted, f, x1, x2, x3, before, load, rising, falling, f_before, c, fall, pc, pt, leapt, quick,
        c0, c1, c2, c3, c4, t0, t1, t2, t3, t4,
    ) = state  # fmt: skip
    sc, st = (c0, c1, c2, c3, c4), (t0, t1, t2, t3, t4)
    own, sensor, table, low, high = gains
    (
        rest, decay_rest, decay_left, decay, inverse, most_um, most_c, learn_c, learn_t, exponent, load_gain, skin,
        jump, log2_nominal, model_fall, sf, s1, s2, s3,
    ) = own  # fmt: skip
    force, _, speed, pressed, valid = measurement

    forward = 1.0 if speed >= 0.0 else -1.0
    turned = forward * before < 0.0
    sign = -1.0 if turned else 1.0
    f, f_before, x1, x2, x3 = sign * f, sign * f_before, sign * x1, sign * x2, sign * x3
    v = max(abs(speed), SLOWEST_M_S)
    way_um, fastest = v * dt * 1e6, skin * v
    load = fma(load_gain, log2(max(pressed * 2.0, 0.04)) - load, load)
    push = exponent * load

    # Correct by the reading.
    error = force - x3
    limit = limit_of(d + push, fall, a)
    share = share_of(c, f, way_um)
    place = place_of(share, v)
    kd, kf = scheduled(place, table.limit), scheduled(place, table.friction)
    k1, k2, k3 = scheduled(place, table.spring), scheduled(place, table.rate), scheduled(place, table.reading)
    lead, trust = scheduled(place, table.lead), scheduled(place, table.trust)
    w = stuck_share(f, limit, rising, fastest, valid)
    leaps = (valid > 0.0) & (abs(f - setpoint_n) > LEAP_N)
    slow = (not leaps) & (leapt == 0.0) & (abs(rising) < 0.5 * fastest)
    steady = slow & (w == 0.0) & (f > 0.15) & (abs(error) < 0.03)
    # A leap downwards reaches the reading sooner than the believed sensor says: it is not the limit that is lower.
    drops = leaps & (f > setpoint_n) & (f - f_before < -1.2 * fastest * dt)
    leapt = 1.0 if drops else max(leapt - LEAP_TICK, 0.0)
    learns = 1.0 if steady else 0.0
    pc = fma(learns * FORGET, fma(sc[4], sc[4], -pc), pc)
    pt = fma(learns * FORGET, fma(st[4], st[4], -pt), pt)
    step_c = min(max(learn_c * error * sc[4] / (pc + 1e-10), -FASTEST_C), FASTEST_C)
    pace = max(v, LEAN_M_S)
    step_c = min(max(LEAN * c * pace * pace, LEAST_LEAN), 1.0) * step_c if step_c > 0.0 else step_c
    c = min(max(fma(learns, step_c, c), 0.0), most_c)
    step_t = min(max(learn_t * error * st[4] / (pt + 5e-9), -FASTEST_FALL), FASTEST_FALL)
    # Friction that falls faster than the skin follows rings: less lag and more effect of vibration are safe beliefs.
    # Where it is the mean excess of its falls that is large, friction goes to and fro: too much lag alone is to blame.
    rings = valid if rising < -2.0 * fastest else 0.0
    shakes = (falling > RINGING_SHARE * fastest) & (falling * v > RINGING_N_M_S2) & (c > CALMED_C)
    c = fma(-CALM_C * (valid if shakes else rings), c, c)
    fall = min(max(fma(CALM_T * rings, fall, fma(learns, step_t, fall)), 0.2), 3.0)
    slides = 1.0 - w
    weighs = min(max(f, 0.1), 2.0)
    per_force, most = 1.0 / weighs, min(jump, LARGEST_UP * weighs)
    up = slides * (1.0 - leapt) * min(max(kd * error, -most), most) * per_force
    d = min(max(fma(LOG2_E, up, d), LOWEST), HIGHEST)
    limit = fma(limit, up, limit)
    f = fma(w * sf, error, fma(slides, min(max(kf * error, -2.0 * jump), 2.0 * jump), f))
    f = min(max(f, -LARGEST_N), LARGEST_N)
    x1, x2 = fma(fma(slides, k1, w * s1), error, x1), fma(fma(slides, k2, w * s2), error, x2)
    x3 = fma(fma(slides, k3, w * s3), error, x3)
    rate = (f - f_before) / dt
    rising = fma(SMOOTH, rate - rising, rising)
    quick = fma(QUICK, rate - quick, quick)
    falling = fma(SMOOTH_FALLS, max(-quick - fastest, 0.0) - falling, falling)

    # Go on to when the command takes effect.
    # Leaps are made by the model: what is learnt around a level is the gain that leaves least there, not the slope.
    leap_fall = min(max(LEAP_SHARE * model_fall, 0.2), 3.0) if leaps else fall
    more = fall - leap_fall
    apart = more * a * a
    a_then = fma(decay_rest, a - command, command)
    limit_then = limit_of(d + push - apart, leap_fall, a_then)
    mean = 0.5 * (limit + limit_then)
    share = share_of(c, mean, way_um)
    mean = limit_then if share > 0.97 else mean
    change = min(share * (mean - f), 1.2 * fastest * dt)
    f_then = fma(rest, change, f)

    # Command.
    short = setpoint_n - f_then
    wanted_limit = max(fma(short, 1.0 / lead, f_then), 0.02)
    trusted = fma(trust, d - trusted, trusted)
    square = (trusted + push - apart - log2(wanted_limit)) / leap_fall
    within = min(max(square, 0.0), most_um * most_um)
    # Once all vibration is off it stays off until friction has all but arrived: near its limit a bristle is slow.
    held = 0.0 if (command <= 0.0) & (short > SHORT_N) else within
    _, command = overdrive_step(a_then, math.sqrt(held), OverdriveGains(decay, inverse, most_um))
    a_next = fma(decay_left, a_then - command, command)
    d_next = min(max(d + fma(more * a_next, a_next, -apart), LOWEST), HIGHEST)
    d, trusted = d_next, trusted + (d_next - d)
    u = min(max(exp2(fma(-model_fall, held, log2_nominal)), low), high)

    # Go on to the next sample.
    k = (kd * per_force, kf, k1, k2, k3)
    added_c = min(max(-share * share * max(mean, 0.05) / way_um * (mean - f), -MOST_ADDED), MOST_ADDED)
    added_t = -HALF_LN_2 * share * mean * fma(a, a, a_then * a_then)
    keep = 0.0 if turned | (abs(sc[4]) > LARGEST_BY_C) | (abs(st[4]) > LARGEST_BY_T) else 1.0
    by_c = sensitivity_step(sc, keep, k, w, share, mean, added_c, sensor)
    by_t = sensitivity_step(st, keep, k, w, share, mean, added_t, sensor)
    x1, x2, x3 = sensor_step(x1, x2, x3, f, f + change, sensor)
    state = TrackerState(
        a_next, command, d, trusted, f + change, x1, x2, x3, forward, load, rising,
        falling, f, c, fall, pc, pt, leapt, quick, *by_c, *by_t,
    )  # fmt: skip
    return state, ForceCommand(u, 1.0 if square != within else 0.0)


@step
def tracker_follow(state: TrackerState, command_um: float, gains: TrackerTick) -> TrackerState:
    """Let the believed plate go where the command in force takes it, not the tracker's own, which no clamp limits."""
    moved = fma(1.0 - gains.own.decay_left, command_um - state.command, state.amplitude)
    return TrackerState(moved, command_um, *state[2:])


TRACKER_LAW = Law(
    "tracker",
    tracker_step,
    TrackerState,
    TrackerTick,
    tracker_gains,
    tracker_start,
    frozen=ESTIMATES,
    follow=tracker_follow,
)
