"""An observer of the friction limit: its logarithm, in which fingers, load and vibration are summands.

Believed, with d the binary logarithm of the limit without vibration, a the amplitude, phi = tau/ln 2 and c the
compliance of the contact (1/s0 of Dahl's law, 0 for a slider), which is told:

    L = 2^(d - phi a^2),   f' = (L - f)/T,  T = c f/v,   springs and pole of the sensor driven by f

f follows by an implicit step, no faster than the skin is stretched. Each reading corrects d, f, springs and pole by the
stationary Kalman gains for a d that drifts (control/limit_gains), in a line over T from a slider's to a slow bristle's.
The command is the amplitude at which L is the set-point, a^2 = (d - log2 f_r)/phi, reached by overdrive: the loop gain
is tau/tau_believed at every force, load and speed.

That one gain is learnt, from the set-point alone. Where phi is wrong, d moves with the set-point as phi - phi_true
times a^2. With z and h what log2 f_r and d do above `SLOW_HZ`:

    phi' = phi z h / (T_l E z^2)   while E z^2 > e^2

The set-point is an instrument: nothing that the finger does is in it, so the loop does not bias what is learnt. phi is
between model / spread and model spread, and begins at the upper end, where the loop gain is least. Nothing is learnt
while the finger sticks, is off the plate, the clamp acts, or the set-point rests (`LEAST_SWING`). phi goes back to its
beginning while readings move ln L by more than is `STATED`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from frictionloop.control.law import ForceCommand
from frictionloop.control.limit_gains import LONGEST
from frictionloop.quantities.arithmetic import exp2, fma, log2, step
from frictionloop.sensing.measurement import Measurement

LOG2_E = 1.4426950408889634
SLOWEST_M_S = 0.002
"""Speed below which T no longer grows (the least that counts as sliding)."""
LEAST_N, MOST_N = 0.1, 2.0
"""Forces by which contact and gains are scaled (assumed: those that fingers are given, and twice as much)."""
LARGEST_UP = 0.4
"""Most that one reading may move ln L: well below 1, as f follows it in a line."""
LARGEST_N, LARGEST_LOG2 = 5.0, 5.0
"""Bounds of f, twice what the sensor reads, and of log2 L as it vibrates: 1/32 to 32 N."""
FASTER = 1.2
"""Rise of friction that still counts as that of the skin, over stiffness times speed (stiffnesses differ)."""
SLOW_HZ = 0.3
"""Corner below which set-point and limit teach nothing: load and moisture drift there (periods of 10 s and more)."""
MEMORY_S = 2.0
"""Of the mean square of the set-point's logarithm: two periods of a sine of 1 Hz (paper, Sec. 4.2)."""
LEAST_SWING = 0.05 * LOG2_E
"""Rms of the set-point's logarithm below which nothing is learnt: as much as roughness does to the limit's."""
WINDOW_S = 0.5
"""Of the mean square of what readings move ln L by: that of a Kalman filter is what drives its state in a period."""
STATED = 0.1
"""Rms of it up to which gains are those of this finger. Friction noise of 5 % rms, 1/f over 2500/0.2 of frequency,
changes by 5 % (2 (ln pi + 0.577 - Ci pi)/ln 12500)^(1/2) = 3.0 % in a period; three times as much is assumed."""
MOST_TAUGHT = 2.0
"""Most of z h over the mean square: of phi at its upper end it is spread - 1."""


class LimitState(NamedTuple):
    """Amplitudes at t_k in um, the second commanded; the limit is d; forces in N, logarithms binary."""

    amplitude: float
    command: float
    limit: float
    friction: float
    spring: float
    rate: float
    reading: float
    forward: float
    """Direction of the last reading, 1 or -1; 0 before the first."""
    fall: float
    """phi = tau / ln 2, um^-2."""
    slow_target: float
    """log2 of the set-point below `SLOW_HZ`, and d."""
    slow_limit: float
    swing: float
    """Mean square of what the set-point's logarithm does above it."""
    stuck: float
    """1 where the skin held friction back in the last period."""
    misfit: float
    """Mean square of what readings move ln L by."""


class LimitGains(NamedTuple):
    """Decays of the believed plate, the believed sensor, gains of a reading, what is told, and the clamp."""

    decay_rest: float
    """Of the plate from the sample to the command's taking effect, and over what is left of the period."""
    decay_left: float
    a11: float
    """Springs and pole over a period, `SuspensionCoefficients`."""
    a12: float
    a21: float
    a22: float
    a31: float
    a32: float
    a33: float
    kd: float
    """Gains on ln L times the force (N/N), of a slider its friction's too; ..s: more of it per period of T."""
    kds: float
    kfs: float
    k1: float
    k1s: float
    k2: float
    k2s: float
    k3: float
    k3s: float
    compliance: float
    """um/N; ``skin`` is the largest rise of friction over the way of a period, N/m."""
    skin: float
    most_um: float
    log2_nominal: float
    """Of the model, with ``model_fall`` its phi: u stands for an amplitude by these."""
    model_fall: float
    spread: float
    learn: float
    """1/T_l, 1/s."""
    low: float
    high: float


@step
def learnt_step(fall: float, z: float, h: float, swing: float, rate: float, spread: float, model: float) -> float:
    """phi + rate phi z h / E z^2, within model/spread to model spread."""
    taught = min(max(z * h / swing, -MOST_TAUGHT), MOST_TAUGHT)
    return min(max(fma(rate * fall, taught, fall), model / spread), model * spread)


@step
def limit_observer_step(
    state: LimitState, measurement: Measurement, setpoint_n: float, gains: LimitGains, dt: float
) -> tuple[LimitState, ForceCommand]:
    """One tick; see the module."""
    a, command, d, f, x1, x2, x3, before, fall, slow_target, slow_limit, swing, was_stuck, misfit = state
    (
        decay_rest, decay_left, a11, a12, a21, a22, a31, a32, a33, kd, kds, kfs, k1, k1s, k2, k2s, k3, k3s,
        compliance, skin, most_um, log2_nominal, model_fall, spread, learn, low, high,
    ) = gains  # fmt: skip
    y, _, speed, _, valid = measurement
    forward = 1.0 if speed >= 0.0 else -1.0
    begins, slides = before == 0.0, valid > 0.5
    sign = -1.0 if forward * before < 0.0 else 1.0
    # The sensor has settled before the first reading.
    f, x2 = y if begins else sign * f, sign * x2
    x1, x3 = y if begins else sign * x1, y if begins else sign * x3

    # The contact.
    way_um = max(abs(speed), SLOWEST_M_S) * dt * 1e6
    force = min(max(f, LEAST_N), MOST_N)
    lag_um = compliance * force
    share = way_um / (lag_um + way_um)
    lag = min(lag_um / way_um, LONGEST)
    fastest, stuck = skin * way_um * 1e-6, was_stuck > 0.5

    # Correct by the reading. A tip that sticks shows no limit, but that it is not as high as believed.
    e = y - x3
    up = fma(kds, lag, kd) * e / force if slides & ((not stuck) | (e < 0.0)) else 0.0
    up = min(max(up, -LARGEST_UP), LARGEST_UP)
    misfit = fma(dt / WINDOW_S, fma(up, up, -misfit), misfit)
    lower = fall * a * a
    d = min(max(fma(LOG2_E, up, d), lower - LARGEST_LOG2), lower + LARGEST_LOG2)
    kf = fma(kfs, lag, kd) if slides & (not stuck) else kd
    f = min(max(fma(kf, e, f), -LARGEST_N), LARGEST_N)
    x1, x2, x3 = fma(fma(k1s, lag, k1), e, x1), fma(fma(k2s, lag, k2), e, x2), fma(fma(k3s, lag, k3), e, x3)

    target = log2(max(setpoint_n, 0.02))
    slow_target, slow_limit = target if begins else slow_target, d if begins else slow_limit
    z, h, slow = target - slow_target, d - slow_limit, 2.0 * math.pi * SLOW_HZ * dt
    slow_target, slow_limit = fma(slow, z, slow_target), fma(slow, h, slow_limit)
    swing = fma(dt / MEMORY_S, fma(z, z, -swing), swing)

    # Command.
    then = fma(decay_rest, a - command, command)
    square = (d - target) / fall
    within = min(max(square, 0.0), most_um * most_um)
    wanted = exp2(fma(-model_fall, within, log2_nominal))
    u = min(max(wanted, low), high)
    held = within if u == wanted else min(max((log2_nominal - log2(u)) / model_fall, 0.0), most_um * most_um)
    decay = decay_rest * decay_left
    command = min(max(fma(-decay, then, math.sqrt(held)) / (1.0 - decay), 0.0), most_um)

    # Learn. The limit that there is stays.
    taught = slides & (not stuck) & (swing > LEAST_SWING * LEAST_SWING) & (square == held)
    new = learnt_step(fall, z, h, swing, learn * dt, spread, model_fall) if taught else fall
    new = spread * model_fall if misfit > STATED * STATED else new
    more = (new - fall) * a * a
    d, slow_limit, fall = d + more, slow_limit + more, new

    # Go on to the next sample.
    a_next = fma(decay_left, then - command, command)
    follows = share * (exp2(fma(-fall * a_next, a_next, d)) - f)
    change = min(follows, fastest) if slides else 0.0
    mean = fma(0.5, change, f)
    s, r = x1 - mean, x3 - mean
    after = LimitState(
        a_next, command, d, f + change,
        fma(a11, s, fma(a12, x2, mean)), fma(a21, s, a22 * x2), fma(a31, s, fma(a32, x2, fma(a33, r, mean))),
        forward, fall, slow_target, slow_limit, swing, 1.0 if slides & (follows > fastest) else 0.0, misfit,
    )  # fmt: skip
    return after, ForceCommand(u, 1.0 if square != held else 0.0)
