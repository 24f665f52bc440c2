"""The disturbance observer as a law: the set-point less what the force has beyond the commands' own effect.

u = clip(f_r - d, low, high), d from `force_observer`, which contains the sensor's resonance and the loop's delay. d is
predicted over the delay as it is (a random walk), and the set-point needs no other way: without a disturbance u = f_r.

What to believe (controller.model): found on fingers(100, 3), scored on the 107 capable of fingers(200, 7), sines of
0.6 +- 0.1 N, 20 mm/s, strokes of 240 mm, no reversal; median / worst decile of the rms error, in mN:

    nominal_n 2.2, resonance_hz 139, sensor_hz 350  Dahl 17.2 / 32.0  slider 16.1 / 34.2  (PI 26 / 42, 38 / 65)
    the same, tremor 30 um and 30 mN for all             14.3 / 28.2         13.0 / 25.9  (PI 21 / 37, 36 / 59)

PI is `RETUNED` with the bench's model, not retuned here; the best of 24 PI laws on fingers(100, 3), over both contacts
and with nominal_n 2.2 too, leaves 28 / 44 (Dahl) and 30 / 47 (slider). Some 150 settings of the observer were tried.

- Much friction: the loop gain is (F/u) (tau/tau_model), 1 for the believed finger. Ms at 0.6 N is 2.0 (Dahl) and 1.8
  (slider) at a gain of 0.7, 3.0 and 2.7 at 1; with nominal_n 0.95 a moist finger has 3.
- A resonance below the true one. Believed at 139 Hz with the true one at 132, 5 % lower, a slider leaves 32 / 53 mN
  (second row), at 125 51 / 82, at 118 68 / 102; with the true one at 139, 145, 152, 160: 13.2, 13.0, 12.8, 12.7 mN.
  Under Dahl's bristles 18.6, 30 and 53 below, 14.5 to 14.7 above.
- A slower pole than the electronics': between theirs and that of bristles, s0 v/(2 pi F), which is not in the model.
- No limit cycle was seen in the spectra of 24 fingers: the strongest 20 Hz above 100 Hz hold 4.5 mN on a slider
  (median), as part of a slope from 100 Hz down.
- Tried on fingers(100, 3) and left out: a slope of d as a further state (bandwidth 320 Hz: 24 to 31 mN under Dahl
  instead of 21), a pole of the contact at 60 Hz (24 and, on a slider, 29 instead of 20); one at 250 Hz gains 0.8 mN.
"""

from __future__ import annotations

from typing import NamedTuple

from frictionloop.control.force_observer import (
    ObserverGains,
    ObserverState,
    held_step,
    observe_step,
    predict_step,
)
from frictionloop.control.law import ForceCommand, Law, clamp_of
from frictionloop.control.observer_gains import observer_gains, observer_start
from frictionloop.parameters import ObserverController
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


def disturbance_observer_gains(controller: ObserverController) -> DisturbanceGains:
    """Return the gains of the law."""
    return DisturbanceGains(observer_gains(controller), float(controller.overdrive), *clamp_of(controller.model))


OBSERVER_LAW = Law(
    "observer",
    disturbance_observer_step,
    ObserverState,
    DisturbanceGains,
    disturbance_observer_gains,
    observer_start,
)
