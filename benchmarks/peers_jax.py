"""The same loop compiled by JAX: by hand (the fast rule in a `scan`), and with diffrax as the solver of each period."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from paper import Array, Paper, Period, draw, lobatto, signals
from solvers import TOLERANCE, derivative


class Jax:
    """`scan` over time, `vmap` over lanes, float64; for a grid, lanes split over `devices` host devices."""

    def __init__(self, devices: int = 1, rule_of: Callable[[Paper], Period] = lobatto) -> None:
        self._rule_of = rule_of
        if "jax" not in sys.modules:  # host devices must be asked for before jax starts
            os.environ["XLA_FLAGS"] = (
                f"{os.environ.get('XLA_FLAGS', '')} --xla_force_host_platform_device_count={os.cpu_count()}"
            )
        import jax

        jax.config.update("jax_enable_x64", True)
        mesh = jax.sharding.Mesh(np.array(jax.devices()[:devices]), ("lanes",))
        self._split = jax.sharding.NamedSharding(mesh, jax.sharding.PartitionSpec("lanes"))
        self._jax = jax
        self._one = jax.jit(self._traces, static_argnums=0)
        self._grid = jax.jit(jax.vmap(self._metric, in_axes=(None, None, 0, 0)), static_argnums=0)

    def _step(self, p: Paper, kp: Any, ki: Any) -> Any:
        jnp, rule = self._jax.numpy, self._rule_of(p)
        plate, weight, sensor = rule.plate.tolist(), rule.weight.tolist(), rule.sensor

        def step(state: Any, now: Any) -> Any:
            (a, g, f_m, integral), (f_r, d, added) = state, now
            e = f_r - f_m
            v = kp * e + integral
            u = jnp.clip(v, p.low, p.f0)
            integral = jnp.where((v - u) * e > 0, integral, integral + ki * p.period_s * e)
            command = jnp.sqrt(jnp.log(p.f0 / u) / p.tau)
            row = (g + d, f_m, u, a, v != u)
            away, f_m = a - command, sensor * f_m + weight[0] * g + added
            for j in range(1, len(weight)):
                a = command + away * plate[j]
                g = p.f0 * jnp.exp(-p.tau * a * a)
                f_m += weight[j] * g
            return (a, g, f_m, integral), row

        return step

    def _traces(self, p: Paper, noise: Any, kp: Any, ki: Any) -> Any:
        driven = signals(p, len(noise), noise, self._jax.numpy)
        start = (0.0, p.f0, p.f0 + driven[1][0], 0.0)
        return self._jax.lax.scan(self._step(p, kp, ki), start, driven)[1]

    def _metric(self, p: Paper, noise: Any, kp: Any, ki: Any) -> Any:
        driven, step = signals(p, len(noise), noise, self._jax.numpy), self._step(p, kp, ki)

        def summed(state: Any, now: Any) -> Any:
            inner, (f_a, *_, clamped) = step(state[0], now)
            return (inner, state[1] + (f_a - now[0]) ** 2, state[2] + clamped), None

        start = ((0.0, p.f0, p.f0 + driven[1][0], 0.0), 0.0, 0.0)
        (_, error2, _), _ = self._jax.lax.scan(summed, start, driven)
        return 1 - error2 / self._jax.numpy.sum((driven[0] - driven[0].mean()) ** 2)

    def one(self, p: Paper, kp: float, ki: float, periods: int) -> Array:
        return np.asarray(self._one(p, draw(p, periods), kp, ki)[0])

    def grid(self, p: Paper, kp: Array, ki: Array, periods: int) -> Array:
        split = self._jax.device_put((kp, ki), self._split)
        return np.asarray(self._grid(p, draw(p, periods), *split))


class Diffrax:
    """diffrax: Tsit5 inside a `scan` over periods, adaptive, compiled by JAX."""

    def __init__(self) -> None:
        import diffrax
        import jax

        jax.config.update("jax_enable_x64", True)
        self._jax, self._diffrax = jax, diffrax
        self._run = jax.jit(self._traces, static_argnums=(0, 2))

    def _traces(self, p: Paper, noise: Any, periods: int, kp: Any, ki: Any) -> Any:
        jnp, dfx = self._jax.numpy, self._diffrax
        t = jnp.arange(periods) / p.rate_hz
        term = dfx.ODETerm(lambda t, x, args: jnp.stack(derivative(t, x, p, *args, xp=jnp)))
        adaptive = dfx.PIDController(**TOLERANCE)

        def step(state: Any, now: Any) -> Any:
            (x, integral), (start, f_r, n) = state, now
            e = f_r - x[1]
            v = kp * e + integral
            u = jnp.clip(v, p.low, p.f0)
            integral = jnp.where((v - u) * e > 0, integral, integral + ki * p.period_s * e)
            command = jnp.sqrt(jnp.log(p.f0 / u) / p.tau)
            solved = dfx.diffeqsolve(
                term,
                dfx.Tsit5(),
                start,
                start + p.period_s,
                p.period_s / 4,
                x,
                (command, n),
                stepsize_controller=adaptive,
            )
            return (solved.ys[-1], integral), p.f0 * jnp.exp(-p.tau * x[0] ** 2) + p.disturbance(start, jnp)

        first = jnp.array([0.0, p.f0 + p.disturbance(0.0)])
        return self._jax.lax.scan(step, (first, 0.0), (t, p.set_point(t, jnp), noise))[1]

    def __call__(self, p: Paper, kp: float, ki: float, periods: int) -> Array:
        return np.asarray(self._run(p, draw(p, periods), periods, kp, ki))
