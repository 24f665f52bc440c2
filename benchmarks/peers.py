"""What people write today for the same loop, by hand: pure Python, NumPy over lanes, Numba.

Each is small, gets the fast rule (exact amplitude, six Lobatto nodes), and evaluates its own set-point and disturbance.
The array versions also run with ten substeps, which is what one writes before looking for a better rule.
"""

from __future__ import annotations

from collections.abc import Callable
from math import exp, log, sqrt

import numpy as np

from paper import Array, Paper, Period, draw, lobatto, signals


def numpy_batch(p: Paper, kp: Array, ki: Array, periods: int, rule_of: Callable[[Paper], Period] = lobatto) -> Array:
    """Arrays over lanes (and nodes), time in a Python loop; returns R2_identity per lane."""
    rule, (f_r, d, added) = rule_of(p), signals(p, periods, draw(p, periods))
    plate, weight, ki_dt = rule.plate[1:, None], rule.weight[1:] * p.f0, ki * p.period_s
    a, g = np.zeros_like(kp), np.full_like(kp, p.f0)
    f_m, integral, error2, clamped = g + d[0], np.zeros_like(kp), np.zeros_like(kp), np.zeros_like(kp)
    for k in range(periods):
        error2 += (g + d[k] - f_r[k]) ** 2
        e = f_r[k] - f_m
        v = kp * e + integral
        u = np.minimum(np.maximum(v, p.low), p.f0)
        clamped += v != u
        integral += np.where((v - u) * e > 0, 0.0, ki_dt * e)
        command = np.sqrt(np.log(p.f0 / u) / p.tau)
        nodes = command + (a - command) * plate
        f = np.exp(-p.tau * nodes * nodes)
        f_m = rule.sensor * f_m + rule.weight[0] * g + weight @ f + added[k]
        a, g = nodes[-1], p.f0 * f[-1]
    return 1 - error2 / np.sum((f_r - f_r.mean()) ** 2)


def python_loop(p: Paper, kp: float, ki: float, periods: int) -> Array:
    """No library in the loop: floats and `math`, the rule written out; returns the trace of f_a."""
    rule, (f_r, d, added) = lobatto(p), signals(p, periods, draw(p, periods))
    return np.array(
        scalar_loop(
            f_r.tolist(),
            d.tolist(),
            added.tolist(),
            kp,
            ki * p.period_s,
            p.f0,
            p.tau,
            p.low,
            tuple(rule.plate.tolist()),
            tuple(rule.weight.tolist()),
            rule.sensor,
        )
    )


def scalar_loop(f_r, d, added, kp, ki_dt, f0, tau, low, plate, weight, sensor):  # type: ignore[no-untyped-def]
    """The loop of `python_loop`; `numba_scalar` compiles the same lines."""
    f_a = []
    a, g, f_m, integral = 0.0, f0, f0 + d[0], 0.0
    for k in range(len(f_r)):
        f_a.append(g + d[k])
        e = f_r[k] - f_m
        v = kp * e + integral
        u = min(max(v, low), f0)
        if (v - u) * e <= 0:
            integral += ki_dt * e
        command = sqrt(log(f0 / u) / tau)
        f_m = sensor * f_m + weight[0] * g + added[k]
        away = a - command
        for j in range(1, 6):
            a = command + away * plate[j]
            g = f0 * exp(-tau * a * a)
            f_m += weight[j] * g
    return f_a


class NumbaScalar:
    """The usual first step: `@njit` on the scalar loop, `prange` over lanes."""

    def __init__(self) -> None:
        import numba

        loop = numba.njit(scalar_loop)

        @numba.njit(parallel=True)
        def lanes(f_r, d, added, kp, ki_dt, f0, tau, low, plate, weight, sensor):  # type: ignore[no-untyped-def]
            out = np.empty(len(kp))
            for i in numba.prange(len(kp)):
                f_a = np.array(loop(f_r, d, added, kp[i], ki_dt[i], f0, tau, low, plate, weight, sensor))
                out[i] = 1 - np.sum((f_a - f_r) ** 2) / np.sum((f_r - f_r.mean()) ** 2)
            return out

        self._loop, self._lanes = loop, lanes

    def _rest(self, p: Paper) -> tuple[object, ...]:
        rule = lobatto(p)
        return p.f0, p.tau, p.low, rule.plate, rule.weight, rule.sensor

    def one(self, p: Paper, kp: float, ki: float, periods: int) -> Array:
        return np.array(self._loop(*signals(p, periods, draw(p, periods)), kp, ki * p.period_s, *self._rest(p)))

    def grid(self, p: Paper, kp: Array, ki: Array, periods: int) -> Array:
        return self._lanes(*signals(p, periods, draw(p, periods)), kp, ki * p.period_s, *self._rest(p))
