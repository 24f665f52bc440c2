"""The limit observer: one step of the C core against the float64 step, and a run of either."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.limit_observer import LimitObserverController, LimitState, limit_observer_gains
from frictionloop.firmware.compiled import state_places

MODEL = fl.bench().controller.model
CONTROLLERS = {
    "bristle": LimitObserverController(delay_s=200e-6, model=MODEL),
    "slider, half a period of delay": LimitObserverController(delay_s=100e-6, compliance_um_per_n=0.0, model=MODEL),
    "soft, nothing learnt": LimitObserverController(compliance_um_per_n=300.0, susceptibility_spread=1.0, model=MODEL),
}
FORCE_N = 2e-5
"""Allowed difference of the force command: a tenth of what the firmware may differ by."""
PLACES = 2.0 ** -np.array(state_places(CONTROLLERS["bristle"]), dtype=float)


def allowed(controller):
    """Steps of each state: of numbers off by half a step, times the gains on a reading and on what follows from it."""
    gains = limit_observer_gains(controller)
    found = dict.fromkeys(LimitState._fields, 8.0)
    # A logarithm in steps of 2^-26 of which a root is taken, then 1/(1 - decay) of a difference.
    found |= {"command": 400.0 / gains.model_fall, "amplitude": 400.0 / gains.model_fall}
    # Gains of up to 25 on an innovation in steps of 2^-24, of forces and logarithms in steps of 2^-28 and 2^-26.
    found |= {"limit": 2000.0, "friction": 4000.0, "slow_limit": 2000.0, "fall": 200.0}
    found |= dict.fromkeys(("spring", "rate", "reading"), 300.0)
    return np.array([found[name] for name in LimitState._fields]) * PLACES


@pytest.mark.parametrize("name", CONTROLLERS)
def test_force_and_states_agree(parity, name):
    controller = CONTROLLERS[name]
    for inputs in (parity.wild(20_000, 1), parity.realistic(20_000, 2)):
        difference, _, states = parity.one_step(controller, inputs)
        print(name, np.abs(difference).max(), np.quantile(np.abs(difference), 0.999))
        for k, f in enumerate(LimitState._fields):
            print("  ", f, np.abs(states[:, k]).max() / PLACES[k], np.quantile(np.abs(states[:, k]), 0.999) / PLACES[k])
