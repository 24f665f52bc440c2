"""What people write today for the same loop with a library's solver: SciPy and python-control.

A general ODE solver steps through each control period with a relative tolerance of 1e-8; python-control's discrete
model lets its user write the update, so it also gets the fast rule.
"""

from __future__ import annotations

from collections.abc import Callable
from math import exp, log, pi, sqrt
from typing import Any

import numpy as np

from paper import Array, Paper, draw, lobatto, signals

TOLERANCE = {"rtol": 1e-8, "atol": 1e-10}
Advance = Callable[[float, float, Array, float, float], Array]
"""(start, stop, state, amplitude command, noise) -> state: the plant over one control period."""


class Controller:
    """The PI of the loop for contenders that call Python once per period."""

    def __init__(self, p: Paper, kp: float, ki: float) -> None:
        self.p, self.kp, self.ki_dt, self.integral = p, kp, ki * p.period_s, 0.0

    def __call__(self, f_r: float, f_m: float) -> float:
        e = f_r - f_m
        v = self.kp * e + self.integral
        u = min(max(v, self.p.low), self.p.f0)
        if (v - u) * e <= 0:
            self.integral += self.ki_dt * e
        return sqrt(log(self.p.f0 / u) / self.p.tau)


def derivative(t: float, x: Any, p: Paper, command: float, noise: float, xp: Any = np) -> list[Any]:
    """Plate and sensor as the paper prints them: da/dt, df_m/dt."""
    force = p.f0 * xp.exp(-p.tau * x[0] * x[0]) + p.disturbance(t, xp)
    return [2 * pi * p.plate_hz * (command - x[0]), 2 * pi * p.sensor_hz * (force + noise - x[1])]


def sampled(p: Paper, kp: float, ki: float, periods: int, advance: Advance) -> Array:
    """Run the sampled controller around a continuous plant; return the trace of f_a."""
    t = np.arange(periods + 1) / p.rate_hz
    f_r, d, noise = p.set_point(t), p.disturbance(t), draw(p, periods)
    control, x, f_a = Controller(p, kp, ki), np.array([0.0, p.f0 + d[0]]), np.empty(periods)
    for k in range(periods):
        f_a[k] = p.f0 * exp(-p.tau * x[0] ** 2) + d[k]
        x = advance(t[k], t[k + 1], x, control(f_r[k], x[1]), noise[k])
    return f_a


def scipy_solve_ivp(p: Paper, kp: float, ki: float, periods: int, **options: Any) -> Array:
    from scipy.integrate import solve_ivp

    def advance(start: float, stop: float, x: Array, command: float, noise: float) -> Array:
        return solve_ivp(derivative, (start, stop), x, args=(p, command, noise), **(options or TOLERANCE)).y[:, -1]

    return sampled(p, kp, ki, periods, advance)


def tight(p: Paper, kp: float, ki: float, periods: int) -> Array:
    """The independent solver that every contender is checked against."""
    return scipy_solve_ivp(p, kp, ki, periods, method="DOP853", rtol=1e-12, atol=1e-14)


def scipy_odeint(p: Paper, kp: float, ki: float, periods: int) -> Array:
    from scipy.integrate import odeint

    def advance(start: float, stop: float, x: Array, command: float, noise: float) -> Array:
        return odeint(derivative, x, [start, stop], args=(p, command, noise), tfirst=True, **TOLERANCE)[-1]

    return sampled(p, kp, ki, periods, advance)


def control_continuous(p: Paper, kp: float, ki: float, periods: int) -> Array:
    """python-control: the plant as a continuous system, `input_output_response` over each period."""
    import control as ct

    plant = ct.nlsys(lambda t, x, u, _: derivative(t, x, p, u[0], u[1]), None, inputs=2, outputs=2, states=2)

    def advance(start: float, stop: float, x: Array, command: float, noise: float) -> Array:
        held = np.array([[command] * 2, [noise] * 2])
        response = ct.input_output_response(plant, [start, stop], held, x, solve_ivp_kwargs=TOLERANCE)
        return response.states[:, -1]

    return sampled(p, kp, ki, periods, advance)


def control_discrete(p: Paper, kp: float, ki: float, periods: int) -> Array:
    """python-control: the whole loop as one discrete system whose update its user wrote."""
    import control as ct

    rule = lobatto(p)
    plate, weight = rule.plate[1:], rule.weight[1:] * p.f0
    f_r, d, added = signals(p, periods, draw(p, periods))

    def update(_: float, state: Array, driven: Array, __: Any) -> Array:
        a, f_m, integral = state
        e = driven[0] - f_m
        v = kp * e + integral
        u = min(max(v, p.low), p.f0)
        if (v - u) * e <= 0:
            integral = integral + ki * p.period_s * e
        command = sqrt(log(p.f0 / u) / p.tau)
        nodes = command + (a - command) * plate
        first = rule.weight[0] * p.f0 * exp(-p.tau * a * a)
        return np.array(
            [nodes[-1], rule.sensor * f_m + first + weight @ np.exp(-p.tau * nodes**2) + driven[2], integral]
        )

    def output(_: float, state: Array, driven: Array, __: Any) -> Array:
        return p.f0 * np.exp(-p.tau * state[:1] ** 2) + driven[1]

    loop = ct.nlsys(update, output, inputs=3, outputs=1, states=3, dt=p.period_s)
    start = np.array([0.0, p.f0 + d[0], 0.0])
    return ct.input_output_response(loop, np.arange(periods) * p.period_s, np.array([f_r, d, added]), start).outputs
