"""What of a system the board does not do is told before it is built, and the carrier is the nearest to the plate."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.firmware.board_fit import (
    BUS_HZ,
    USUAL_TICKS,
    amplitude_left,
    carrier_hz,
    carrier_said,
    misfits,
    period_ticks,
)
from frictionloop.quantities.schema import firmware_folder

CARRIER_HZ = 36e6 / 783
"""Of an image for the bench."""


def at(frequency_hz, q=230.0):
    return fl.bench().evolve({"plate.frequency_hz": frequency_hz, "plate.q": q})


def test_clock_and_usual_period_are_those_of_the_boards_source():
    text = (firmware_folder() / "boards/teensy31/carrier.c").read_text()
    assert float(re.search(r"(\d+) MHz / FL_CARRIER_TICKS", text)[1]) * 1e6 == BUS_HZ
    assert int(re.search(r"#define FL_CARRIER_TICKS (\d+)", text)[1]) == USUAL_TICKS == period_ticks(fl.bench())
    assert carrier_hz(fl.bench()) == CARRIER_HZ and period_ticks(fl.feasible()) == USUAL_TICKS


@given(st.floats(2e3, 150e3))
def test_no_other_whole_period_is_nearer_to_the_plate(frequency_hz):
    ticks = period_ticks(at(frequency_hz))
    off = [abs(BUS_HZ / frequency_hz - each) for each in (ticks - 1, ticks, ticks + 1)]
    assert min(off) == off[1]


def test_a_plate_that_the_timer_cannot_reach_is_refused():
    with pytest.raises(
        fl.FrictionloopError, match=r"plate.frequency_hz = 1000 Hz: the board's carrier must be from 1099"
    ):
        period_ticks(at(1000.0))
    assert "must be from 1099" in misfits(at(1000.0))[0]


def test_what_is_left_is_the_response_of_a_resonator_beside_its_peak():
    plate = fl.ResonantPlate(frequency_hz=45000.0, q=230.0)
    # An independent form: |1 / (1 - x^2 + j x / Q)| over its value Q at the resonance, x = f / f0.
    x = CARRIER_HZ / plate.frequency_hz
    resonator = abs(1.0 / (1.0 - x**2 + 1j * x / plate.q)) / plate.q
    assert amplitude_left(plate, CARRIER_HZ) == pytest.approx(resonator, rel=0.03)
    assert amplitude_left(fl.ResonantPlate(frequency_hz=CARRIER_HZ), CARRIER_HZ) == 1.0
    at_corner = fl.ResonantPlate(frequency_hz=CARRIER_HZ / (1.0 - 1.0 / 460.0), q=230.0)
    assert amplitude_left(at_corner, CARRIER_HZ) == pytest.approx(np.sqrt(0.5), rel=0.01)


def test_another_rate_and_a_plate_between_two_carriers_are_told_and_the_bench_is_not():
    assert misfits(fl.bench()) == misfits(fl.feasible()) == []
    (rate,) = misfits(at(38200.0).evolve({"controller.rate_hz": 4000.0}))
    assert "controller.rate_hz = 4000 Hz" in rate and "firmware runs at 5000 Hz only" in rate
    between = at(BUS_HZ / 942.4, q=2000.0)
    (plate,) = misfits(between)
    assert (
        "the nearest carrier is 38217 Hz, 36 MHz / 942, where the plate gives 50.7 % of its amplitude at resonance"
        in plate
    )
    assert carrier_said(between) in plate and carrier_said(fl.feasible()) == ""
    words = plate.partition("`")[2].partition("`")[0].split()
    there = dict(zip((word.removeprefix("--") for word in words[::2]), map(float, words[1::2]), strict=True))
    share = amplitude_left(between.plate, BUS_HZ / 942)
    assert there["plate.pulse_ticks"] == 942
    assert there["plate.max_amplitude_um"] == pytest.approx(share * between.plate.max_amplitude_um, rel=1e-3)
    (told,) = misfits(between.evolve({"plate.pulse_ticks": 942}))
    assert told.endswith("are to be those at this carrier") and "`" not in told


def test_strokes_that_the_position_sensor_cannot_follow_are_told_with_a_scale_that_can():
    far = fl.bench().evolve({"motion.stroke_mm": 80.0})
    (said,) = misfits(far)
    assert "goes to 40 mm from the middle, and is read to 32.8 mm with board.position_m_per_count = 1e-06" in said
    scale = float(said.partition("sensor_saturated; ")[2].split()[0])
    assert misfits(far.evolve({"board.position_m_per_count": scale})) == []


def test_steps_are_told_which_a_table_of_points_has_not():
    levels = {"kind": "steps", "times_s": (0.0, 1.0), "levels_n": (0.4, 0.6)}
    (said,) = misfits(fl.bench().evolve({"setpoint": levels}))
    assert "1024 points with straight lines between them, which miss steps in a run above 0.2 s" in said
    assert misfits(fl.bench().evolve({"setpoint": levels | {"times_s": (0.0,), "levels_n": (0.4,)}})) == []
