"""Small signals at steady sliding: the linearised laws against the simulated ones."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numba import njit

from frictionloop.physics.contact import ContactState, contact_coefficients
from frictionloop.physics.contact_bristle import dahl_step, lugre_step
from frictionloop.physics.contact_linear import linearise_dahl, linearise_lugre, linearise_slider
from frictionloop.physics.contact_slider import slider_step
from frictionloop.quantities import FrictionloopError

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


def linearised(law, limit, speed):
    if law == "slider":
        return linearise_slider()
    return linearise_dahl(limit, speed, S0) if law == "dahl" else linearise_lugre(limit, speed, S0, S1)


def simulated(law, limit, speed, frequency, dt):
    """Return F/Fc for a limit modulated by 1e-6 of itself, from five periods after 40 ms."""
    per_period = round(1 / (frequency * dt))
    settle = per_period * math.ceil(0.04 * frequency)
    wave = np.exp(2j * np.pi * frequency * (np.arange(settle + 5 * per_period) + 0.5) * dt)
    start = math.copysign(limit, speed)
    state = ContactState(start / K, 0.0, start / S0, limit / S0)
    forces = RUN[law](state, limit * (1 + 1e-6 * wave.imag), speed, contact_coefficients(dt, K, C, M, S0, S1))
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
    law = linearise_dahl(0.5, -0.02, S0)
    assert law.response(0.0) == 1.0
    assert abs(law.response(S0 * 0.02 / 0.5 / (2 * math.pi))) == pytest.approx(math.sqrt(0.5), rel=1e-14)
    assert linearise_lugre(0.5, 0.02, S0, 0.0).response(100.0) == linearise_dahl(0.5, 0.02, S0).response(100.0)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((0.0, 0.02, S0), "limit_n = 0 N: must be finite and above 0"),
        ((0.5, 0.0, S0), "speed_m_s = 0 m/s: must be finite and not 0"),
        ((0.5, math.nan, S0), "speed_m_s = nan m/s: must be finite and not 0"),
        ((0.5, 0.02, -1.0), "bristle_stiffness_n_per_m = -1 N/m: must be finite and above 0"),
        ((0.5, 0.02, S0, -1.0), "bristle_damping_n_s_per_m = -1 N s/m: must be finite and at least 0"),
    ],
)
def test_no_linearisation_without_sliding(arguments, says):
    with pytest.raises(FrictionloopError) as error:
        linearise_lugre(*arguments)
    assert str(error.value) == says
    if len(arguments) == 3:
        with pytest.raises(FrictionloopError):
            linearise_dahl(*arguments)
