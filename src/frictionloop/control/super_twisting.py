"""Super-twisting sliding mode on the friction force (paper, ref. [16]), the force being that of an observer.

Sliding variable: s = p + d - f_r, the force that `force_observer` predicts for the time when the command is applied,
less the set-point. The raw reading, a resonance and 300 us late, would leave a limit cycle. The command sets the rate
of the force, v, on top of the equivalent control, which moves the force with the set-point:

    s' = v + phi,  v = -k1 |s|^(1/2) sign(s) + w,  w' = -k2 sign(s)

With |phi'| <= L, k1 = 1.5 sqrt(L) and k2 = 1.1 L bring s to 0 in finite time (Levant 1993; Moreno & Osorio 2012).

Stepped implicitly: v uses the s that it leads to. An explicit step always has a sign to switch, and chatters by
about k2 dt^2 at half the control rate; the implicit one has an interval of b = s + dt (w + phi) within k2 dt^2 in which
s goes to 0 exactly, and so needs no boundary layer. phi is taken from the last step, where it is known: s is then left
with what phi changed by, at most L dt^2. In that interval u = f_r - d - (d - d before), the disturbance observer's with
d predicted; outside, the rate of u is bounded, which is what a large step of d meets.

What to believe is as in `disturbance_observer`.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

from frictionloop.control.force_observer import ObserverGains, ObserverState, held_step, observe_step, predict_step
from frictionloop.control.law import ForceCommand, Law, clamp_of
from frictionloop.control.observer_gains import observer_gains, observer_start
from frictionloop.parameters.block import NotNegative
from frictionloop.parameters.controller import Observing
from frictionloop.quantities.arithmetic import fma, step
from frictionloop.sensing.measurement import Measurement


class SuperTwistingController(Observing):
    """Super-twisting sliding mode on the observed friction force (paper, ref. [16])."""

    kind: Literal["super_twisting"] = "super_twisting"
    k1: NotNegative = 474.0
    """Gain on the root of the sliding variable, sqrt(N)/s: 1.5 sqrt(L), L in N/s^2 the largest phi'."""
    k2: NotNegative = 1.1e5
    """Gain of the integral, N/s^2: 1.1 L."""


class SuperTwistingState(NamedTuple):
    """What the observer believes, and the sliding mode: w, d of the last sample and the set-point then, N."""

    observer: ObserverState
    w: float
    before: float
    target: float


class SuperTwistingGains(NamedTuple):
    """Gains of the observer and of the sliding mode, and the clamp, N."""

    observer: ObserverGains
    reach: float
    """dt k1, N^(1/2)."""
    band: float
    """dt^2 k2, N."""
    fastest: float
    """Most that the plate can do in a period, N."""
    overdriven: float
    """1 where overdrive follows."""
    low: float
    high: float


@step
def super_twist_step(s: float, w: float, drift: float, reach: float, band: float) -> tuple[float, float]:
    """s+ = s + drift - reach |s+|^(1/2) sign(s+) + w+, w+ = w - band xi, xi in sign(s+): return s+ and w+.

    All in N: w and drift are dt w and dt phi, reach is dt k1 (N^(1/2)), band is dt^2 k2. The step's rate is
    v dt = s+ - s - drift.
    """
    b = s + drift + w
    pulled = min(max(b, -band), band)
    # |s+| + reach |s+|^(1/2) = |b| - band
    root = 0.5 * (math.sqrt(fma(reach, reach, 4.0 * abs(b - pulled))) - reach)
    ahead = root * root
    return ahead if b > 0.0 else -ahead, w - pulled


@step
def super_twisting_step(
    state: SuperTwistingState, measurement: Measurement, setpoint_n: float, gains: SuperTwistingGains, dt: float
) -> tuple[SuperTwistingState, ForceCommand]:
    """Force wanted next: f_r - d - drift + s+; with overdrive u is this, else u takes the believed plate there.

    w is 0 where the clamp acts and bounded by what the plate can do, so that nothing winds up. While the finger does
    not slide, d is that of the last sample at which it did.
    """
    observer, reach, band, fastest, overdriven, low, high = gains
    believed, w, before, target = state
    seen = observe_step(believed, measurement, observer)
    ahead, d = seen.ahead, seen.kept
    begins = believed.forward == 0.0
    drift = 0.0 if begins else d - before
    s, w = super_twist_step(0.0 if begins else ahead + d - target, w, drift, reach, band)
    v = setpoint_n - d - drift + s
    wanted = min(max(v, low), high)
    free = v == wanted
    w = min(max(w, -fastest), fastest) if free else 0.0
    held = held_step(ahead, wanted, observer, low, high)
    after = predict_step(seen, held, observer)
    u = wanted if overdriven > 0.5 else held
    return SuperTwistingState(after, w, d, setpoint_n), ForceCommand(u, 0.0 if free else 1.0)


def super_twisting_gains(controller: SuperTwistingController) -> SuperTwistingGains:
    """Return the gains of the law."""
    observer, dt, model = observer_gains(controller), 1.0 / controller.rate_hz, controller.model
    fastest = (model.nominal_n - model.floor_n) * (1.0 - observer.pp)
    return SuperTwistingGains(
        observer,
        controller.k1 * dt,
        controller.k2 * dt * dt,
        fastest,
        float(controller.overdrive),
        *clamp_of(model),
    )


def super_twisting_start(controller: SuperTwistingController) -> SuperTwistingState:
    """Return the state before the first reading, which finds s = 0."""
    return SuperTwistingState(observer_start(controller), 0.0, 0.0, 0.0)


LAW = Law(
    "super_twisting",
    super_twisting_step,
    SuperTwistingState,
    SuperTwistingGains,
    super_twisting_gains,
    super_twisting_start,
)
