"""The C core closing the loop around the plant of the bench, against the simulator's float64 loop, by statistics."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl

MODEL = fl.bench().controller.model
SYSTEMS = {
    "pi retuned": fl.bench().evolve(fl.RETUNED),
    "notch, fed forward and overdriven": fl.bench().evolve(
        {"controller": fl.NotchPiController(delay_s=200e-6, feedforward=True, overdrive=True, model=MODEL)}
    ),
    "limit observer": fl.bench().evolve({"controller.kind": "limit_observer"}),
    "lookup": fl.bench().evolve({"controller": fl.LookupController(delay_s=200e-6, model=MODEL)}),
}
PERIODS, SEED = 10_000, 8


def closed_by_firmware(parity, system, setpoints):
    """Friction force at each sample."""
    law, loop, forces = parity.FixedLaw(system.controller), fl.Stepper(system, seed=SEED), np.empty(len(setpoints))
    told = np.rint(setpoints * 2.0**28).astype(np.int32)
    for k in range(len(setpoints)):
        forces[k] = loop.force_n
        rows, _ = parity.quantised(np.array([loop.measured]), setpoints[k : k + 1])
        command = law.run(rows[0], told[k : k + 1])[0, 2]
        loop.tick(command / 2.0**28)
    return forces


@pytest.mark.parametrize("name", SYSTEMS)
def test_residual_is_that_of_the_float64_loop(parity, name):
    system = SYSTEMS[name]
    run = fl.simulate(system, duration_s=PERIODS / 5000.0, seed=SEED)
    setpoints = run["f_r"].values.astype(float)
    forces = closed_by_firmware(parity, system, setpoints)
    scored = run["sliding"].values
    residuals = [np.sqrt(np.mean((f_a - setpoints)[scored] ** 2)) for f_a in (forces, run["f_a"].values)]
    assert residuals[0] == pytest.approx(residuals[1], rel=0.02)
