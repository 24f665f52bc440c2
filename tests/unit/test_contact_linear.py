"""Small signals at steady sliding: the linearised contact against the simulated one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from contact_constants import constants_of
from numba import njit

from frictionloop.parameters import Skin
from frictionloop.physics.contact import ContactState, bristle_step, linearise_slip

K, C, M, DT = 1e3, 1.0, 1e-4, 2e-5


@njit(error_model="numpy")
def run(state, limits, speed, coefficients):
    forces = np.empty(limits.size)
    for i in range(limits.size):
        state, forces[i] = bristle_step(state, limits[i], speed, coefficients)
    return forces


def simulated(length_um, limit, speed, frequency, dt):
    """Return F/Fc for a limit modulated by 1e-6 of itself, from five periods after 40 ms."""
    per_period = round(1 / (frequency * dt))
    settle = per_period * math.ceil(0.04 * frequency)
    wave = np.exp(2j * np.pi * frequency * (np.arange(settle + 5 * per_period) + 0.5) * dt)
    start = math.copysign(limit, speed)
    state = ContactState(start / K, 0.0, start)
    forces = run(state, limit * (1 + 1e-6 * wave.imag), speed, constants_of(dt, K, C, M, length_um))
    forces *= math.copysign(1.0, speed)
    return np.mean((forces[settle:] - limit) * np.conj(wave[settle:])) * 2j / (1e-6 * limit)


@pytest.mark.parametrize("length_um", [0.0, 11.5, 30.0])
@pytest.mark.parametrize("limit", [0.3, 0.7])
@pytest.mark.parametrize("speed", [0.02, -0.02, 0.15])
@pytest.mark.parametrize("frequency", [20.0, 100.0, 500.0])
def test_frequency_response(length_um, limit, speed, frequency):
    """Steps of 20 us are off by less than 0.1 % of Fc, and at least second order takes steps to the linear law."""
    expected = complex(linearise_slip(Skin(slip_length_um=length_um), limit, speed).response(frequency))
    coarse, fine = (abs(simulated(length_um, limit, speed, frequency, dt) - expected) for dt in (DT, DT / 4))
    assert coarse < 1e-3
    assert fine < coarse / 12 + 1e-9  # rounding of a force modulated by 1e-6


def test_the_cutoff_rises_with_speed_as_it_was_measured():
    """13.8 Hz per mm/s (arXiv 2505.11162), whatever the force."""
    for speed in (0.02, 0.15):
        law = linearise_slip(Skin(), 0.5, -speed)
        assert law.response(0.0) == 1.0
        assert abs(law.response(13.8 * 1e3 * speed)) == pytest.approx(math.sqrt(0.5), rel=2e-3)
