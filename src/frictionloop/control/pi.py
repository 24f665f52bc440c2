"""The PI law of the paper with a clamp and conditional integration (Section 2.3)."""

from __future__ import annotations

from typing import NamedTuple, TypeGuard

from frictionloop.control.law import ForceCommand, Law, clamp_of
from frictionloop.parameters import PiController, Timing
from frictionloop.quantities import Lti
from frictionloop.quantities.scalar_math import fma, step
from frictionloop.sensing.measurement import Measurement


class PiState(NamedTuple):
    """Integral I in N."""

    integral: float


class PiGains(NamedTuple):
    """kp (N/N), ki (1/s) and the clamp [low, high] in N that the controller's model gives."""

    kp: float
    ki: float
    low: float
    high: float


@step
def pi_step(
    state: PiState, measurement: Measurement, setpoint_n: float, gains: PiGains, dt: float
) -> tuple[PiState, ForceCommand]:
    """e = f_r - f_m; v = kp e + I; u = clip(v, low, high); I += ki dt e unless e pushes v further into the clamp.

    Without a sliding finger (``valid`` 0) there is no error to act on: u = I, which is held.
    """
    (integral,) = state
    kp, ki, low, high = gains
    force, _, _, _, valid = measurement
    kp, ki = valid * kp, valid * ki
    error = setpoint_n - force
    v = fma(kp, error, integral)
    u = min(max(v, low), high)
    pushes = ((v > high) & (error > 0.0)) | ((v < low) & (error < 0.0))
    integral = integral if pushes else fma(ki * dt, error, integral)
    return PiState(integral), ForceCommand(u, 1.0 if v != u else 0.0)


@step
def pi_begin(state: PiState, force_n: float, setpoint_n: float, gains: PiGains) -> PiState:
    """I = u."""
    return PiState(force_n)


PI_LAW = Law("pi", pi_step, PiState, PiGains, lambda c: PiGains(c.kp, c.ki, *clamp_of(c.model)), begin=pi_begin)


def is_pi(controller: Timing) -> TypeGuard[PiController]:
    """Tell whether a controller runs this law: parameters from outside may inherit from `PiController`."""
    return controller.kind == PI_LAW.kind


def linearise_pi(controller: PiController) -> Lti:
    """Return C(s) = kp + ki/s with the controller's delay, error to force command."""
    return Lti((controller.kp, controller.ki), (1.0, 0.0), controller.delay_s)
