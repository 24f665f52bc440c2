"""The board in the loop with the bench: it does what the simulated controller does, as statistics tell."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.device.codec import encode
from frictionloop.device.simulated_boards import HostBoard, Sample
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.parameters.presets import RETUNED
from frictionloop.sensing.measurement import Measurement
from tests.helpers.host_frames import SESSION, heartbeat, hello

SETTLED = slice(3000, 8000)


def bench(kind: str) -> fl.System:
    """Return the bench at a constant set-point from mid-stroke, with a law's own gains, the PI's those that hold."""
    plain = fl.bench().evolve(RETUNED).model_dump()
    if kind != "pi":
        plain["controller"] = {"kind": kind, "delay_s": 200e-6, "model": plain["controller"]["model"]}
    plain["setpoint"] = {"kind": "constant", "offset_n": 0.6}
    plain["motion"]["start"] = 0.1
    return fl.System.model_validate(plain)


def counts(told: Measurement, system: fl.System) -> Sample:
    """Return a reading as the converters give it."""
    force = np.clip(round(told.force / (2 * system.sensor.range_n / 2**16)), -32768, 32767)
    board = system.board
    return Sample(
        int(force), 0, round(told.position / board.position_m_per_count), round(told.load / board.load_n_per_count)
    )


def with_the_board(system: fl.System, ticks: int) -> np.ndarray:
    """Return the friction force at every tick, the board closing the loop from the first."""
    plant, board, force = fl.Stepper(system, seed=1), HostBoard(firmware_words(system)), np.empty(ticks)
    board.receive(hello() + encode("mode", 1, SESSION, state=2), 0)
    for k in range(ticks):
        if k % 500 == 0:
            board.receive(heartbeat(k + 2), 200 * k)
            board.transmit(200 * k)
        drive = board.tick(counts(plant.measured, system), 200 * k)
        force[k] = plant.force_n
        plant.tick(drive.amplitude_um)
    return force


@pytest.mark.parametrize("kind", ["pi", "lookup", "notch_pi", "limit_observer"])
def test_the_error_is_that_of_the_simulated_controller(kind: str):
    system = bench(kind)
    run = fl.simulate(system, duration_s=SETTLED.stop / 5000, seed=1)
    simulated = np.sqrt(np.mean((run.f_a.values[SETTLED] - 0.6) ** 2))
    found = np.sqrt(np.mean((with_the_board(system, SETTLED.stop)[SETTLED] - 0.6) ** 2))
    # Converter steps of load and position and the first 0.1 s differ; the noise is the same.
    assert found == pytest.approx(simulated, rel=0.05)
