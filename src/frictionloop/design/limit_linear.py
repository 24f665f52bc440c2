"""The limit observer for small signals, and a system whose limit observer has learnt and knows its contact."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionloop.analysis.linear import LinearLoop
from frictionloop.analysis.state_space import StateSpace
from frictionloop.control.limit_gains import LONGEST, limit_rows
from frictionloop.parameters import Model, Skin, Strokes, SuspendedSensor, System
from frictionloop.sensing.force_sensor import suspension_coefficients

TOLD = "limit_observer"
"""The law that is told its contact: what it holds on the other, it holds there when it is told that."""
LEARNT = 1.2
"""Loop gain over that of a known susceptibility: what is learnt is less far off (studies/pages/limit-observer.md)."""


def compliance_of(system: System) -> float:
    """Return the compliance of a finger's contact at 0.6 N, um/N; 0 without a skin."""
    finger = system.finger
    return finger.slip_length_um / 0.6 if isinstance(finger, Skin) else 0.0


def lag_of(loop: LinearLoop) -> float:
    """Return the time constant of a loop's contact in control periods, z/v."""
    motion = loop.system.motion
    if not isinstance(motion, Strokes):
        return 0.0
    way_um = 1e3 * motion.speed_mm_s * loop.plant.period_s
    finger = loop.system.finger
    return finger.slip_length_um / way_um if isinstance(finger, Skin) else 0.0


def small_signals(model: Model, rate_hz: float, bandwidth_hz: float, spring_noise: float, lag: float) -> StateSpace:
    """Return the law around a rest, from f_m/F to tau_believed a^2, for a delay of one period.

    States: tau a^2 at the sample and a period on, ln L, f/F, springs and pole.
    """
    quick, slow = limit_rows(model, rate_hz, bandwidth_hz, spring_noise)
    k = quick + (slow - quick) * min(lag, LONGEST) / LONGEST
    springs = suspension_coefficients(
        SuspendedSensor(resonance_hz=model.resonance_hz, q=model.resonance_q, cutoff_hz=model.sensor_hz), 1.0 / rate_hz
    )
    _, ahead, d, f, x1, x2, x3, y = np.eye(8)
    e = y - x3
    d, f, x1, x2, x3 = d + k[0] * e, f + k[1] * e, x1 + k[2] * e, x2 + k[3] * e, x3 + k[4] * e
    after = f + (d - ahead - f) / (lag + 1.0)
    mean = (f + after) / 2.0
    s, r = x1 - mean, x3 - mean
    rows = np.vstack(
        [
            ahead, d, d, after,
            springs.a11 * s + springs.a12 * x2 + mean, springs.a21 * s + springs.a22 * x2,
            springs.a31 * s + springs.a32 * x2 + springs.a33 * r + mean,
        ]
    )  # fmt: skip
    return StateSpace(rows[:, :7], rows[:, 7:], d[None, :7], d[None, 7:], 1.0 / rate_hz, ("f_m",), ("square",))


def largest_gain(system: System) -> float:
    """Return the loop gain that margins are held up to: `LEARNT`, or less where the susceptibility is told closely.

    What there is and what is learnt are each within the spread of what is told.
    """
    spread: float = getattr(system.controller, "susceptibility_spread", LEARNT)
    return min(LEARNT, spread**2)


def learnt(system: System, gain: float | None = None) -> System:
    """Return a system whose limit observer has a loop gain, the largest if none is given; another law as it is."""
    friction: Any = system.friction
    if system.controller.kind != TOLD or not hasattr(friction, "susceptibility_per_um2"):
        return system
    tau: float = friction.susceptibility_per_um2 / (largest_gain(system) if gain is None else gain)
    return system.evolve({"controller.susceptibility_spread": 1.0, "controller.model.susceptibility_per_um2": tau})


def knowing(system: System, gain: float | None = None) -> System:
    """Return a system whose limit observer knows its contact and has a loop gain, the largest if none is given."""
    return learnt(system, gain).evolve({"controller.compliance_um_per_n": compliance_of(system)})
