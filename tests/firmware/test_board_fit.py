"""What of a system the board does not do is told before it is built."""

import re

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.firmware.board_fit import BUS_HZ, CARRIER_HZ, PERIOD, amplitude_left, misfits
from frictionloop.quantities.schema import firmware_folder


def test_the_carrier_is_that_of_the_boards_source():
    text = (firmware_folder() / "boards" / "teensy31" / "carrier.c").read_text()
    assert int(re.search(r"PERIOD = (\d+)", text)[1]) == PERIOD
    assert float(re.search(r"(\d+) MHz / 783", text)[1]) * 1e6 == BUS_HZ


def test_what_is_left_is_the_response_of_a_resonator_beside_its_peak():
    plate = fl.ResonantPlate(frequency_hz=45000.0, q=230.0)
    # An independent form: |1 / (1 - x^2 + j x / Q)| over its value Q at the resonance, x = f / f0.
    x = CARRIER_HZ / plate.frequency_hz
    resonator = abs(1.0 / (1.0 - x**2 + 1j * x / plate.q)) / plate.q
    assert amplitude_left(plate) == pytest.approx(resonator, rel=0.03)
    assert amplitude_left(fl.ResonantPlate(frequency_hz=CARRIER_HZ)) == 1.0
    at_corner = fl.ResonantPlate(frequency_hz=CARRIER_HZ / (1.0 - 1.0 / 460.0), q=230.0)
    assert amplitude_left(at_corner) == pytest.approx(np.sqrt(0.5), rel=0.01)


def test_another_plate_and_another_rate_are_told_and_the_bench_is_not():
    assert misfits(fl.bench()) == []
    rate, carrier = misfits(fl.bench().evolve({"plate.frequency_hz": 38200.0, "controller.rate_hz": 4000.0}))
    assert "controller.rate_hz = 4000 Hz" in rate and "the firmware at 5000 Hz" in rate
    assert "PERIOD = 942" in carrier and "1.1 % of its amplitude" in carrier
    assert misfits(fl.feasible()) == []
