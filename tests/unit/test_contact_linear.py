"""Small signals at steady sliding: the linearised laws against the simulated ones."""

from __future__ import annotations

import math

import numpy as np
import pytest
from contact_constants import constants_of
from numba import njit

from frictionloop.parameters import Skin
from frictionloop.physics.contact import ContactState, linearise_slip
from frictionloop.physics.contact_laws import dahl_step, lugre_step, slider_step

K, C, M, S0, S1, DT = 1e3, 1.0, 1e-4, 2e4, 1.4, 2e-5
STEPS = {"dahl": dahl_step, "lugre": lugre_step, "slider": slider_step}


def lift(step):
    @njit(error_model="numpy")
    def run(state, limits, speed, coefficients):
        forces = np.empty(limits.size)
        for i in range(limits.size):
            state, forces[i] = step(state, limits[i], speed, coefficients)
        return forces

    return run


RUN = {law: lift(step) for law, step in STEPS.items()}


def linearised(law, limit, speed, s1=S1):
    return linearise_slip(Skin(contact=law, bristle_stiffness_n_m=S0, bristle_damping_n_s_m=s1), limit, speed)


def simulated(law, limit, speed, frequency, dt):
    """Return F/Fc for a limit modulated by 1e-6 of itself, from five periods after 40 ms."""
    per_period = round(1 / (frequency * dt))
    settle = per_period * math.ceil(0.04 * frequency)
    wave = np.exp(2j * np.pi * frequency * (np.arange(settle + 5 * per_period) + 0.5) * dt)
    start = math.copysign(limit, speed)
    state = ContactState(start / K, 0.0, start / S0, limit / S0)
    forces = RUN[law](state, limit * (1 + 1e-6 * wave.imag), speed, constants_of(dt, K, C, M, S0, S1))
    forces *= math.copysign(1.0, speed)
    return np.mean((forces[settle:] - limit) * np.conj(wave[settle:])) * 2j / (1e-6 * limit)


@pytest.mark.parametrize("law", STEPS)
@pytest.mark.parametrize("limit", [0.3, 0.7])
@pytest.mark.parametrize("speed", [0.02, -0.02, 0.15])
@pytest.mark.parametrize("frequency", [20.0, 100.0, 500.0])
def test_frequency_response(law, limit, speed, frequency):
    """Steps of 20 us are off by less than 0.1 % of Fc, and at least second order takes steps to the linear law."""
    expected = complex(linearised(law, limit, speed).response(frequency))
    coarse, fine = (abs(simulated(law, limit, speed, frequency, dt) - expected) for dt in (DT, DT / 4))
    assert coarse < 1e-3
    assert fine < coarse / 12 + 1e-9  # rounding of a force modulated by 1e-6


def test_dahls_pole():
    law = linearised("dahl", 0.5, -0.02)
    assert law.response(0.0) == 1.0
    assert abs(law.response(S0 * 0.02 / 0.5 / (2 * math.pi))) == pytest.approx(math.sqrt(0.5), rel=1e-14)
    assert linearised("lugre", 0.5, 0.02, 0.0).response(100.0) == linearised("dahl", 0.5, 0.02).response(100.0)
