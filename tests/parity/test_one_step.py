"""One step of each law from the same state and the same quantised input: the C core against the float64 step."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.compiled import host_library
from frictionloop.control.laws import LAWS

FORCE_N = 2e-4
"""Allowed difference of the force command."""


def section(zeros, poles, gain=1.0):
    return (*(gain * np.poly(zeros)).tolist(), *np.poly(poles)[1:].tolist())


FREE = (section([0.98 + 0.17j, 0.98 - 0.17j], [0.3, 0.2]), section([0.5, 0.2], [0.6, -0.4]))
HELD = (
    section([0.99 + 0.01j, 0.99 - 0.01j], [0.9978 + 0.0127j, 0.9978 - 0.0127j], 0.5),
    section([0.9991, 0.98], [0.9994, 0.9947], 0.8),
    section([0.7, -0.3], [0.97, 0.5], -0.9),
    section([0.4, 0.1], [0.9, 0.2], -1.1),
)
UNHELD = (section([1.2, 0.5], [0.99 + 0.1j, 0.99 - 0.1j], 0.1), section([0.3, 0.2], [0.9995, 0.2], 0.5)) * 2
MODEL = fl.bench().controller.model
AHEAD = {"feedforward": True, "model": MODEL}
CONTROLLERS = {
    "pi as printed": fl.bench().controller,
    "pi retuned": fl.PiController(kp=0.062, ki=134.0, model=MODEL),
    "lookup": fl.LookupController(model=MODEL),
    "filtered pi, no section": fl.FilteredPiController(model=MODEL),
    "notch": fl.NotchPiController(delay_s=200e-6, **AHEAD),
    "notch, overdriven": fl.NotchPiController(delay_s=330e-6, overdrive=True, **AHEAD),
    "free sections": fl.FilteredPiController(sections=FREE, kp=0.3, delay_s=600e-6, **AHEAD),
    "held sections": fl.FilteredPiController(sections=(*FREE, *HELD), kp=0.4, ki=60.0, **AHEAD),
    "sections that cannot be held": fl.FilteredPiController(sections=UNHELD, kp=0.01, ki=5.0, model=MODEL),
}


def check(parity, controller, inputs):
    worst, states = parity.one_step_differences(controller, inputs)
    assert worst < FORCE_N
    return worst, states


@pytest.mark.parametrize("name", CONTROLLERS)
def test_force_command_agrees(parity, name):
    for inputs in (parity.wild(20_000, 1), parity.realistic(20_000, 2)):
        worst, states = check(parity, CONTROLLERS[name], inputs)
        print(name, worst, np.max(np.abs(states), axis=0))
