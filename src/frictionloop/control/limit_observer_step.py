"""An observer of the friction limit: its logarithm, in which fingers, load and vibration are summands.

Believed, with d the binary logarithm of the limit without vibration, a the amplitude, phi = tau/ln 2 and z the slip
length of the contact (Balasubramanian, Pool & Vardar 2025, arXiv 2505.11162: friction's cutoff is v/(2 pi z)):

    L = 2^(d - phi a^2),   f' = (L - f)/T,  T = z/v,   springs and pole of the sensor driven by f

f follows by an implicit step. Each reading corrects d, f, springs and pole by the stationary Kalman gains for a d that
drifts (`limit_rows` of control/limit_observer), in a line over T from a slider's to a slow bristle's. The command is
the amplitude at which L is the set-point, a^2 = (d - log2 f_r)/phi, reached by overdrive: the loop gain is the finger's
tau over the believed one at every force, load and speed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from frictionloop.control.law import ForceCommand
from frictionloop.quantities.scalar_math import exp2, fma, log2, step
from frictionloop.sensing.measurement import Measurement

LOG2_E = 1.4426950408889634
SLOWEST_M_S = 0.002
"""Speed below which T no longer grows (the least that counts as sliding)."""
LONGEST = 7.5
"""T in periods up to which gains follow it (assumed): 1.5 ms at 5 kHz, that of a slip length of 11.5 um at 8 mm/s."""
LEAST_N, MOST_N = 0.1, 2.0
"""Forces by which gains are scaled (assumed: those that fingers are given, and twice as much)."""
LARGEST_UP = 0.4
"""Most that one reading may move ln L: well below 1, as f follows it in a line."""
LARGEST_N, LARGEST_LOG2 = 5.0, 5.0
"""Bounds of f and of what it follows, twice what the sensor reads, and of log2 L as it vibrates: 1/32 to 32 N."""


class LimitState(NamedTuple):
    """Amplitudes at t_k in um, the second commanded; the limit is d; forces in N."""

    amplitude: float
    command: float
    limit: float
    friction: float
    spring: float
    rate: float
    reading: float
    forward: float
    """Direction of the last reading, 1 or -1; 0 before the first."""


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
    slip_um: float
    most_um: float
    fall: float
    """phi, um^-2."""
    log2_nominal: float
    """Of the model, with ``model_fall`` its phi: u stands for an amplitude by these."""
    model_fall: float
    low: float
    high: float


@step
def limit_observer_step(
    state: LimitState, measurement: Measurement, setpoint_n: float, gains: LimitGains, dt: float
) -> tuple[LimitState, ForceCommand]:
    """One tick; see the module. While the finger does not slide d stays."""
    a, command, d, f, x1, x2, x3, before = state
    (
        decay_rest, decay_left, a11, a12, a21, a22, a31, a32, a33, kd, kds, kfs, k1, k1s, k2, k2s, k3, k3s,
        slip_um, most_um, fall, log2_nominal, model_fall, low, high,
    ) = gains  # fmt: skip
    y, _, speed, _, valid = measurement
    forward = 1.0 if speed >= 0.0 else -1.0
    begins, slides = before == 0.0, valid > 0.5
    sign = -1.0 if forward * before < 0.0 else 1.0
    # The sensor has settled before the first reading.
    f, x2 = y if begins else sign * f, sign * x2
    x1, x3 = y if begins else sign * x1, y if begins else sign * x3

    # Correct by the reading.
    way_um = max(abs(speed), SLOWEST_M_S) * dt * 1e6
    lag = min(slip_um / way_um, LONGEST)
    e, force = y - x3, min(max(f, LEAST_N), MOST_N)
    up = fma(kds, lag, kd) * e / force if slides else 0.0
    up = min(max(up, -LARGEST_UP), LARGEST_UP)
    lower = fall * a * a
    d = min(max(fma(LOG2_E, up, d), lower - LARGEST_LOG2), lower + LARGEST_LOG2)
    f = min(max(fma(fma(kfs, lag, kd) if slides else kd, e, f), -LARGEST_N), LARGEST_N)
    x1, x2, x3 = fma(fma(k1s, lag, k1), e, x1), fma(fma(k2s, lag, k2), e, x2), fma(fma(k3s, lag, k3), e, x3)

    # Command.
    then = fma(decay_rest, a - command, command)
    square = (d - log2(max(setpoint_n, 0.02))) / fall
    within = min(max(square, 0.0), most_um * most_um)
    wanted = exp2(fma(-model_fall, within, log2_nominal))
    u = min(max(wanted, low), high)
    held = within if u == wanted else min(max((log2_nominal - log2(u)) / model_fall, 0.0), most_um * most_um)
    decay = decay_rest * decay_left
    command = min(max(fma(-decay, then, math.sqrt(held)) / (1.0 - decay), 0.0), most_um)

    # Go on to the next sample.
    a_next = fma(decay_left, then - command, command)
    limit = min(exp2(fma(-fall * a_next, a_next, d)), LARGEST_N)
    change = way_um / (slip_um + way_um) * (limit - f) if slides else 0.0
    mean = fma(0.5, change, f)
    s, r = x1 - mean, x3 - mean
    after = LimitState(
        a_next, command, d, f + change,
        fma(a11, s, fma(a12, x2, mean)), fma(a21, s, a22 * x2), fma(a31, s, fma(a32, x2, fma(a33, r, mean))),
        forward,
    )  # fmt: skip
    return after, ForceCommand(u, 1.0 if square != held else 0.0)
