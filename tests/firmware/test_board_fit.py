"""What of a system the board does not do is told before it is built."""

import re

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.firmware import board_fit
from frictionloop.firmware.board_fit import BUS_HZ, SOURCE, amplitude_left, carrier_hz, carrier_misses, misfits
from frictionloop.quantities.schema import firmware_folder

CARRIER_HZ = 36e6 / 783
"""Of the repository's own image."""


@pytest.fixture
def clone(monkeypatch, tmp_path):
    """Return a function that writes a firmware folder with another line PERIOD, which the commands then read."""
    source = (firmware_folder() / SOURCE).read_text()
    (tmp_path / SOURCE).parent.mkdir(parents=True)

    def write(line):
        (tmp_path / SOURCE).write_text(re.sub(r"PERIOD = 783,", line, source))
        monkeypatch.setattr(board_fit, "firmware_folder", lambda: tmp_path)

    return write


def test_the_clock_is_that_of_the_boards_source():
    text = (firmware_folder() / SOURCE).read_text()
    assert float(re.search(r"(\d+) MHz / 783", text)[1]) * 1e6 == BUS_HZ
    assert carrier_hz() == CARRIER_HZ


def test_a_changed_period_in_the_clone_is_what_a_plate_is_compared_with(clone):
    at_38_khz = fl.bench().evolve({"plate.frequency_hz": 38000.0})
    assert carrier_misses(at_38_khz) and not carrier_misses(fl.bench())
    clone("PERIOD = 947,")
    assert misfits(at_38_khz) == [] and not carrier_misses(at_38_khz)
    (told,) = misfits(fl.bench())
    assert "carrier is at 38015 Hz" in told and "(PERIOD = 947)" in told and "PERIOD = 783 in firmware/" in told


def test_a_period_that_is_no_number_is_said_and_not_guessed(clone):
    clone("PERIOD = 36000000 / 38000,")
    with pytest.raises(fl.FrictionloopError, match=r"carrier\.c: has no PERIOD = NUMBER"):
        misfits(fl.bench())


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
