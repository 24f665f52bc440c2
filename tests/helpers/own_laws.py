"""Control laws as somebody writes them outside the package: a PI with a dead band, and an integral alone."""

from __future__ import annotations

from typing import Literal, NamedTuple

import frictionloop as fl


class DeadBandPi(fl.Timing):
    kind: Literal["dead_band_pi"] = "dead_band_pi"
    kp: float = 2.0
    ki: float = 400.0
    band_n: float = 0.002
    """Errors up to it count as none."""


class Integral(fl.Timing):
    kind: Literal["integral"] = "integral"
    ki: float = 30.0


class State(NamedTuple):
    integral: float


class DeadBandGains(NamedTuple):
    kp: float
    ki: float
    band_n: float
    low: float
    high: float


class IntegralGains(NamedTuple):
    ki: float
    low: float
    high: float


@fl.step
def dead_band_pi(state, measured, setpoint_n, gains, dt):
    error = setpoint_n - measured.force
    beyond = max(error - gains.band_n, 0.0) + min(error + gains.band_n, 0.0)
    v = gains.kp * beyond + state.integral
    u = min(max(v, gains.low), gains.high)
    pushes = ((v > gains.high) & (beyond > 0.0)) | ((v < gains.low) & (beyond < 0.0))
    return State(state.integral + (0.0 if pushes else gains.ki * dt * beyond)), fl.ForceCommand(
        u, 1.0 if v != u else 0.0
    )


@fl.step
def integral(state, measured, setpoint_n, gains, dt):
    error = setpoint_n - measured.force
    u = min(max(state.integral, gains.low), gains.high)
    pushes = ((state.integral > gains.high) & (error > 0.0)) | ((state.integral < gains.low) & (error < 0.0))
    moved = 0.0 if pushes else gains.ki * dt * error
    return State(state.integral + moved), fl.ForceCommand(u, 1.0 if state.integral != u else 0.0)


@fl.step
def begin(state, force_n, setpoint_n, gains):
    return State(force_n)


def register_both() -> None:
    fl.register(fl.Law("dead_band_pi", dead_band_pi, State, DeadBandGains, begin=begin), DeadBandPi)
    fl.register(fl.Law("integral", integral, State, IntegralGains, begin=begin), Integral)
