"""The limit observer for small signals: the matrices that its design uses, against the Jacobian of its step."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.design.limit_linear import knowing, lag_of, small_signals

FREQUENCY_HZ = np.geomspace(1.0, 2400.0, 60)


@pytest.mark.parametrize("length_um", [11.5, 0.0])
@pytest.mark.parametrize("gain", [1.0, 1.2])
@pytest.mark.parametrize("speed", [20.0, 80.0])
def test_the_loop_of_the_design_is_that_of_the_step(speed, gain, length_um):
    changed = {"controller.kind": "limit_observer", "finger.slip_length_um": length_um, "motion.speed_mm_s": speed}
    system = knowing(fl.bench().evolve(changed), gain)
    loop = fl.linearise(system, force_n=0.6)
    c = system.controller
    law = small_signals(c.model, c.rate_hz, c.bandwidth_hz, c.spring_noise, lag_of(loop)).response(FREQUENCY_HZ)[
        :, 0, 0
    ]
    # Behind overdrive, and tau_believed a^2 in place of the force command.
    decay = math.exp(-2.0 * math.pi * c.model.plate_hz / c.rate_hz)
    back = np.exp(-2j * np.pi * FREQUENCY_HZ / c.rate_hz)
    plant = loop.plant.response(FREQUENCY_HZ)[:, 1, 0]
    plant = plant / loop.elements.plate.num[-1] * loop.elements.plate.den[-1]
    expected = gain * plant * law * (1.0 - decay * back) / (1.0 - decay)
    assert loop.responses(FREQUENCY_HZ)["G"] == pytest.approx(expected, rel=2e-4)
