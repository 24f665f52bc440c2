"""Dahl and LuGre steps of 20 us against Radau (scipy) on the continuous equations, mean forces over each step.

The reference carries the impulse of the force as a fifth state, so that means over steps are compared with means.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from contact_constants import constants_of
from numba import njit
from scipy.integrate import solve_ivp

from frictionloop.physics.contact import ContactState
from frictionloop.physics.contact_laws import dahl_step, lugre_step

DT = 2e-5
K, C, M, S0, S1 = 1e3, 1.0, 1e-4, 2e4, 1.4


def lift(step):
    @njit(error_model="numpy")
    def run(state, limits, speeds, coefficients):
        forces = np.empty(limits.size)
        for i in range(limits.size):
            state, forces[i] = step(state, limits[i], speeds[i], coefficients)
        return forces

    return run


RUN = {"dahl": lift(dahl_step), "lugre": lift(lugre_step)}
DAMPING = {"dahl": 0.0, "lugre": S1}


def held(level):
    return lambda t: np.full_like(t, level)


def landing(t):
    """Return a limit that rises from 1 mN to 0.5 N over 5 ms."""
    return 0.001 + 0.499 * (0.5 - 0.5 * np.cos(np.pi * np.clip(t / 5e-3, 0.0, 1.0)))


def fall(t):
    """Return a limit that falls from 0.5 N by a factor of 10 over 1 ms."""
    return 0.5 * 10.0 ** -np.clip(t / 1e-3, 0.0, 1.0)


def reversal(v):
    return lambda t: v * np.cos(2 * np.pi * t / 0.08)


def settled(force):
    return [force / K, 0.0, force / S0]


def scenarios(v):
    """Return name -> limit in N, speed in m/s, start, duration in s."""
    duration = 0.02 if v > 0.1 else 0.05
    return {
        "landing in 5 ms": (landing, held(v), settled(0.0), duration),
        "landing at once": (held(0.5), held(v), settled(0.0), duration),
        "step up": (held(0.75), held(v), settled(0.35), duration),
        "step down": (held(0.35), held(v), settled(0.75), 0.02),
        "reversal": (held(0.5), reversal(v), settled(0.5), 0.08),
        "limit falls by 10 in 1 ms": (fall, held(v), settled(0.5), 0.02),
    }


CASES = [(law, v, name) for law in RUN for v in (0.02, 0.15) for name in scenarios(v)]


@cache
def reference(law, v, name):
    """Return the mean force over each 20 us from a solver that knows nothing of the steps."""
    limit, speed, start, duration = scenarios(v)[name]
    s1 = DAMPING[law]

    def parts(t, y):
        x, u, z = y[:3]
        fc, slip = float(limit(np.float64(t))), float(speed(np.float64(t))) - u
        zdot = slip - S0 * abs(slip) * z / fc
        return x, u, z, fc, slip, zdot, s1 / (1 + s1 * abs(slip) / (4 * fc))

    def rates(t, y):
        x, u, z, _, _, zdot, damping = parts(t, y)
        force = S0 * z + damping * zdot
        return [u, (force - C * u - K * x) / M, zdot, 1e4 * force]  # the impulse scaled to the size of the others

    def jacobian(t, y):
        _, _, z, fc, slip, zdot, damping = parts(t, y)
        sign = math.copysign(1.0, slip)
        zdot_u, zdot_z = -1 + S0 * sign * z / fc, -S0 * abs(slip) / fc
        damping_u = sign * damping**2 / (4 * fc)
        force_u, force_z = damping * zdot_u + damping_u * zdot, S0 + damping * zdot_z
        return [
            [0, 1, 0, 0],
            [-K / M, (force_u - C) / M, force_z / M, 0],
            [0, zdot_u, zdot_z, 0],
            [0, 1e4 * force_u, 1e4 * force_z, 0],
        ]

    t = np.arange(round(duration / DT) + 1) * DT
    found = solve_ivp(rates, (0, t[-1]), [*start, 0.0], "Radau", t, jac=jacobian, rtol=1e-10, atol=1e-13)
    assert found.success
    return np.diff(found.y[3]) / 1e4 / DT


def simulated(law, v, name, parts=1):
    limit, speed, start, duration = scenarios(v)[name]
    steps = round(duration / DT) * parts
    middles = (np.arange(steps) + 0.5) * DT / parts
    coefficients = constants_of(DT / parts, K, C, M, S0, DAMPING[law])
    forces = RUN[law](ContactState(*start, 0.0), limit(middles), speed(middles), coefficients)
    return forces.reshape(-1, parts).mean(axis=1)


@pytest.mark.slow
@pytest.mark.parametrize(("law", "v", "name"), CASES)
def test_force_in_every_20_us(law, v, name):
    error = simulated(law, v, name) - (exact := reference(law, v, name))
    assert np.abs(error).max() < 1e-3  # N, asked
    # The slow part: where the force changes by less than 1 N/s per mm/s, as fast as the skin lets it rise.
    slow = np.abs(np.gradient(exact, DT)) < 1e3 * v
    assert slow.sum() > 100
    assert np.sqrt(np.mean(error[slow] ** 2)) < 1e-4


@pytest.mark.parametrize("law", RUN)
@pytest.mark.parametrize("name", ["landing in 5 ms", "step up"])
def test_second_order(law, name):
    exact = reference(law, 0.15, name)
    errors = [np.sqrt(np.mean((simulated(law, 0.15, name, parts) - exact) ** 2)) for parts in (1, 2, 4)]
    assert errors[1] < errors[0] / 3.5
    assert errors[2] < errors[1] / 3.5
