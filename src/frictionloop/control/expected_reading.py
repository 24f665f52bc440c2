"""What the force sensor should read if the controller's model were right: the set-point through delay, plate, sensor.

The set-point is known before the sensor can tell of it. Against this reading, and not against the set-point, the error
holds only what the model does not know, so feed-forward and feedback do not fight over a step.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from frictionloop.parameters import LowpassSensor, SuspendedSensor
from frictionloop.quantities.scalar_math import fma, step
from frictionloop.sensing.force_sensor import suspension_coefficients


class ExpectedState(NamedTuple):
    """Forces in N at a sample: commands under way, believed force, and what follows from it in the sensor."""

    command_1: float
    """Command of the period before; two more behind it."""
    command_2: float
    command_3: float
    driven: float
    """Force that overdrive believes in: the plate's, without the delay."""
    plate: float
    """Force at the plate, delayed."""
    spring: float
    rate: float
    reading: float
    """What the sensor should read."""


class ExpectedGains(NamedTuple):
    """Exact steps over one period, as deviations from the force held, so that the gain at rest is 1 by construction."""

    overdrive: float
    """p/(1 - p) with the plate's decay p, 0 without overdrive."""
    whole: float
    """Whole periods of the delay, 0 to 3; -1 without feed-forward."""
    decay: float
    """Of the plate over a period, p."""
    newest: float
    """Share of the newest command in the plate's force at the end of the period; decay + newest + older = 1."""
    mean_decay: float
    mean_newest: float
    """The same for the mean over the period."""
    a11: float
    a12: float
    a21: float
    a22: float
    a31: float
    a32: float
    a33: float
    """Springs and electronics, `SuspensionCoefficients`."""


@step
def expected_step(
    state: ExpectedState, setpoint_n: float, low_n: float, high_n: float, gains: ExpectedGains
) -> ExpectedState:
    """One control period of the believed plant, driven by the set-point f_r.

    c = clip(f_r + p/(1 - p) (f_r - f)), f += (1 - p)(c - f): overdrive (c = f_r without), clipped to the clamp widened
    to f_r. The plate's p_{k+1} and its mean over the period are weighted sums of p_k and of the two commands in force
    before and after the switch within the period. Springs and pole take that mean as held: x - F decays.
    """
    c1, c2, c3, driven, plate, spring, rate, reading = state
    overdrive, whole, decay, newest, mean_decay, mean_newest, a11, a12, a21, a22, a31, a32, a33 = gains
    wanted = fma(overdrive, setpoint_n - driven, setpoint_n)
    c = min(max(wanted, min(low_n, setpoint_n)), max(high_n, setpoint_n))
    new = c if whole < 0.5 else (c1 if whole < 1.5 else (c2 if whole < 2.5 else c3))
    old = c1 if whole < 0.5 else (c2 if whole < 1.5 else c3)
    mean = fma(mean_decay, plate - old, fma(mean_newest, new - old, old))
    s, r = spring - mean, reading - mean
    return ExpectedState(
        c,
        c1,
        c2,
        fma(1.0 - decay, c - driven, driven),
        fma(decay, plate - old, fma(newest, new - old, old)),
        fma(a11, s, fma(a12, rate, mean)),
        fma(a21, s, a22 * rate),
        fma(a31, s, fma(a32, rate, fma(a33, r, mean))),
    )


def expected_gains(controller: Any) -> ExpectedGains:
    """Return the gains for a controller's model, delay and rate; all zero but ``whole`` without feed-forward."""
    if not controller.feedforward:
        return ExpectedGains(*[0.0] * len(ExpectedGains._fields))._replace(whole=-1.0)
    model, dt = controller.model, 1.0 / controller.rate_hz
    periods = controller.delay_s * controller.rate_hz
    whole = math.floor(periods + 1e-9)  # as the simulator rounds: a whole delay stays whole
    rest = periods - whole if periods - whole > 1e-9 else 0.0
    corner = 2.0 * math.pi * model.plate_hz * dt
    decay = math.exp(-corner)
    newest, mean_decay = -math.expm1(-corner * (1.0 - rest)), -math.expm1(-corner) / corner
    springs = suspension_coefficients(_sensor(model), dt)
    return ExpectedGains(
        overdrive=decay / (1.0 - decay) if controller.overdrive else 0.0,
        whole=float(whole),
        decay=decay,
        newest=newest,
        mean_decay=mean_decay,
        mean_newest=1.0 - rest - newest / corner,
        a11=springs.a11,
        a12=springs.a12,
        a21=springs.a21,
        a22=springs.a22,
        a31=springs.a31,
        a32=springs.a32,
        a33=springs.a33,
    )


def expected_start(controller: Any) -> ExpectedState:
    """Return the state at t = 0: no vibration, so the believed f0 everywhere and the sensor settled on it."""
    force = controller.model.nominal_n
    return ExpectedState(force, force, force, force, force, force, 0.0, force)


def _sensor(model: Any) -> SuspendedSensor | LowpassSensor:
    if model.resonance_hz == 0.0:
        return LowpassSensor(cutoff_hz=model.sensor_hz)
    return SuspendedSensor(resonance_hz=model.resonance_hz, q=model.resonance_q, cutoff_hz=model.sensor_hz)
