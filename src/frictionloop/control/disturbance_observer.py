"""The disturbance observer as a law: the set-point less what the force has beyond the commands' own effect.

u = clip(f_r - d, low, high), d from `force_observer`, which contains the sensor's resonance and the loop's delay. d is
predicted over the delay as it is (a random walk), and the set-point needs no other way: without a disturbance u = f_r.

What to believe (controller.model; measured in studies/pages/beliefs.md):

- Much friction: the loop gain is (F/u) (tau/tau_model), 1 for the believed finger.
- A resonance below the true one: too low is benign, 5 % too high doubles what a slider leaves.
- A slower pole than the electronics': between theirs and that of bristles, s0 v/(2 pi F), which is not in the model.
"""

from __future__ import annotations

from typing import NamedTuple

from frictionloop.control.force_observer import ObserverGains, ObserverState, held_step, observe_step, predict_step
from frictionloop.control.law import ForceCommand, Law, clamp_of
from frictionloop.control.observer_gains import observer_gains, observer_start
from frictionloop.quantities.arithmetic import step
from frictionloop.sensing.measurement import Measurement


class DisturbanceGains(NamedTuple):
    """Gains of the observer, 1 where overdrive follows, and the clamp, N."""

    observer: ObserverGains
    overdriven: float
    low: float
    high: float


@step
def disturbance_observer_step(
    state: ObserverState, measurement: Measurement, setpoint_n: float, gains: DisturbanceGains, dt: float
) -> tuple[ObserverState, ForceCommand]:
    """u = clip(f_r - d, low, high).

    While the finger does not slide, d is that of the last sample at which it did.
    """
    observer, overdriven, low, high = gains
    seen = observe_step(state, measurement, observer)
    v = setpoint_n - seen.kept
    u = min(max(v, low), high)
    held = held_step(seen.ahead, u, observer, low, high) if overdriven > 0.5 else u
    return predict_step(seen, held, observer), ForceCommand(u, 1.0 if v != u else 0.0)


OBSERVER_LAW = Law(
    "observer",
    disturbance_observer_step,
    ObserverState,
    DisturbanceGains,
    lambda c: DisturbanceGains(observer_gains(c), float(c.overdrive), *clamp_of(c.model)),
    observer_start,
)
