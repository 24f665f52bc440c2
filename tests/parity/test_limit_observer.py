"""The limit observer: one step of the C core against the float64 step."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.limit_observer import LimitObserverController, limit_observer_gains
from frictionloop.control.limit_step import LimitState
from frictionloop.firmware.compiled_core import state_places

MODEL = fl.bench().controller.model
CONTROLLERS = {
    "bristle": LimitObserverController(delay_s=200e-6, model=MODEL),
    "slider, half a period of delay": LimitObserverController(delay_s=100e-6, slip_length_um=0.0, model=MODEL),
    "soft, no margin": LimitObserverController(slip_length_um=180.0, susceptibility_margin=1.0, model=MODEL),
}
FORCE_N = 2e-5
"""Allowed difference of the force command: a tenth of what the firmware may differ by."""
PLACES = 2.0 ** -np.array(state_places(CONTROLLERS["bristle"]), dtype=float)
LEAST_N = 0.1
"""Least force by which a correction of the limit's logarithm is divided."""


def allowed(controller):
    """Allowed difference of each next state.

    An innovation is off by a step of 2^-24 N, which the gains enlarge, and that of the limit 1/force too. A square is
    off by a few steps of 2^-25, of which a root is taken near 0: half of the places; 1/(1 - decay) comes on top.
    """
    gains = limit_observer_gains(controller)
    lag = 7.5
    innovation = 2.0**-24
    limit = 3.0 * innovation * (gains.kd + lag * abs(gains.kds)) / LEAST_N * 1.5 + 8 * 2.0**-26
    friction = 4.0 * innovation * (gains.kd + lag * max(abs(gains.kfs), gains.kds)) + 5.0 * limit
    spring = 4.0 * innovation * (1.0 + gains.k1 + gains.k2 + gains.k3) + friction
    amplitude = np.sqrt(limit / gains.model_fall)
    found = {"amplitude": amplitude, "command": amplitude / (1.0 - gains.decay_rest * gains.decay_left)}
    found |= {"limit": limit, "friction": friction, "spring": spring, "rate": spring, "reading": spring}
    return np.array([found.get(name, 4.0 * place) for name, place in zip(LimitState._fields, PLACES, strict=True)])


def check(controller, difference, states):
    assert np.max(np.abs(difference)) < FORCE_N
    assert np.all(np.max(np.abs(states), axis=0) <= allowed(controller))
    # Nearly all are far closer: a root near 0 and a force of 0.1 N are seldom.
    assert np.all(np.quantile(np.abs(states), 0.99, axis=0) <= 300 * PLACES)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_force_and_states_agree(parity, name):
    controller = CONTROLLERS[name]
    for inputs in (parity.wild(20_000, 1), parity.realistic(20_000, 2)):
        difference, _, states = parity.one_step(controller, inputs)
        check(controller, difference, states)


@pytest.mark.slow
@pytest.mark.parametrize("name", CONTROLLERS)
def test_force_and_states_agree_a_million_times(parity, name):
    for inputs in (parity.wild(500_000, 5), parity.realistic(500_000, 6)):
        difference, _, states = parity.one_step(CONTROLLERS[name], inputs)
        check(CONTROLLERS[name], difference, states)
