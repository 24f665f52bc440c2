"""The friction force earlier than the sensor tells it: a linear observer that knows plate, suspension, pole and delay.

Believed force on the sensor: p + d. p is what the law's own commands make of the plate, d the unknown rest: friction
that the model misses, roughness, tremor. Between samples, in N, with commands applied ``delay_s`` after their sample:

    p' = wp (c - p)                                       plate, c the command that is held
    x1' = w x2,  x2' = w (p + d - x1 - x2/Q)              suspension
    x3' = wc (x1 - x3),  y = x3 + noise                   electronics
    d' = white noise

stepped exactly over a period, with the Kalman gains of the steady state (control/observer_gains).

This is the model for small signals of a finger like the believed one. Of another the command's own effect is off by the
factor (F/u) (tau/tau_model): what is over goes into d, and the loop gain is that factor. Where it is above 1 the loop
has less margin, so rather believe too much friction than too little. With overdrive c is the image in N of what it
commands, limited like the forces; the true plate slews up to twice as fast between far levels.
"""

from __future__ import annotations

from typing import NamedTuple

from frictionloop.quantities.arithmetic import fma, step
from frictionloop.sensing.measurement import Measurement


class ObserverState(NamedTuple):
    """Believed forces in N at t_k, and the commands on their way; the order is what the steps unpack."""

    plate: float
    """p at the sample."""
    ahead: float
    """p when the command of this sample will be applied: all that is on its way has acted."""
    spring: float
    rate: float
    reading: float
    rest: float
    """d, which goes on following the reading while the finger does not slide."""
    kept: float
    """d of the last sample under a sliding finger: the one that laws use."""
    slid: float
    """Whether the finger slid at the last sample."""
    forward: float
    """Direction of the last reading, 1 or -1; 0 before the first one."""
    now: float
    """The command in force, then those under way."""
    next1: float
    next2: float
    next3: float
    next4: float
    next5: float
    next6: float
    next7: float
    next8: float


class ObserverGains(NamedTuple):
    """Believed step, row by row, from p, x1, x2, x3, the commands before (o) and after (n) the switch, and d."""

    pp: float
    po: float
    pn: float
    x1p: float
    x11: float
    x12: float
    x1o: float
    x1n: float
    x1d: float
    x2p: float
    x21: float
    x22: float
    x2o: float
    x2n: float
    x2d: float
    x3p: float
    x31: float
    x32: float
    x33: float
    x3o: float
    x3n: float
    x3d: float
    k1: float
    """Kalman gains of x1, x2, x3 and d."""
    k2: float
    k3: float
    kd: float
    whole: float
    """Whole periods of delay."""
    inverse: float
    """1/(1 - pp), for the command that takes the plate somewhere in one period."""
    limit: float
    """Largest |d| in N."""


@step
def observe_step(state: ObserverState, measurement: Measurement, gains: ObserverGains) -> ObserverState:
    """Correct the state by one reading; the estimate of the friction force at its time is then ``plate`` + ``kept``.

    A reading counts along the motion, so at a reversal all forces on the sensor change their sign. While the finger
    does not slide (``valid`` 0) the observer follows the reading with a d of its own, which keeps the suspension in
    step; ``kept`` waits. When sliding begins again d goes on from there, and no kick follows.
    """
    p, ahead, x1, x2, x3, d, kept, slid, forward, h0, h1, h2, h3, h4, h5, h6, h7, h8 = state
    y, _, speed, _, valid = measurement
    k1, k2, k3, kd, limit = gains.k1, gains.k2, gains.k3, gains.kd, gains.limit
    direction = 1.0 if speed >= 0.0 else -1.0
    begins, turns, slides = forward == 0.0, direction * forward < 0.0, valid > 0.5
    sign = -1.0 if turns else 1.0
    # The sensor has settled before the first reading.
    x1, x2, x3 = y if begins else sign * x1, sign * x2, y if begins else sign * x3
    d = y - p if begins else (-2.0 * p - d if turns else d)
    d = kept if slides & ((slid < 0.5) | turns) & (not begins) else d
    e = y - x3
    d = min(max(fma(kd, e, d), -limit), limit)
    x1, x2, x3, kept = fma(k1, e, x1), fma(k2, e, x2), fma(k3, e, x3), d if slides else kept
    return ObserverState(p, ahead, x1, x2, x3, d, kept, valid, direction, h0, h1, h2, h3, h4, h5, h6, h7, h8)


@step
def predict_step(state: ObserverState, command: float, gains: ObserverGains) -> ObserverState:
    """Advance by one period, with the ``command`` decided at its start, in N and as it will be held."""
    p, ahead, x1, x2, x3, d, kept, slid, forward, o, h1, h2, h3, h4, h5, h6, h7, h8 = state
    (
        pp, po, pn, x1p, x11, x12, x1o, x1n, x1d, x2p, x21, x22, x2o, x2n, x2d,
        x3p, x31, x32, x33, x3o, x3n, x3d, _, _, _, _, whole, _, _,
    ) = gains  # fmt: skip
    n = command if whole == 0.0 else h1
    h1, h2, h3, h4 = h2, h3, h4, h5
    h5, h6, h7 = h6, h7, h8
    h1, h2 = command if whole == 1.0 else h1, command if whole == 2.0 else h2
    h3, h4 = command if whole == 3.0 else h3, command if whole == 4.0 else h4
    h5, h6 = command if whole == 5.0 else h5, command if whole == 6.0 else h6
    h7, h8 = command if whole == 7.0 else h7, command if whole == 8.0 else h8
    return ObserverState(
        fma(pp, p, fma(po, o, pn * n)),
        fma(pp, ahead - command, command),
        fma(x1p, p, fma(x11, x1, fma(x12, x2, fma(x1o, o, fma(x1n, n, x1d * d))))),
        fma(x2p, p, fma(x21, x1, fma(x22, x2, fma(x2o, o, fma(x2n, n, x2d * d))))),
        fma(x3p, p, fma(x31, x1, fma(x32, x2, fma(x33, x3, fma(x3o, o, fma(x3n, n, x3d * d)))))),
        d, kept, slid, forward, n, h1, h2, h3, h4, h5, h6, h7, h8,
    )  # fmt: skip


@step
def held_step(ahead: float, wanted: float, gains: ObserverGains, low: float, high: float) -> float:
    """c = clip((w - pp a)/(1 - pp), low, high): the command that takes the plate from a to w within a period."""
    return min(max(fma(-gains.pp, ahead, wanted) * gains.inverse, low), high)
