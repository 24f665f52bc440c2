"""What of a system the board does otherwise is found before it is built; the carrier is the nearest to the plate."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.firmware.board_compatibility import (
    BUS_HZ,
    USUAL_TICKS,
    amplitude_left,
    board_findings,
    carrier_hz,
    ceiling_findings,
    converter_findings,
    gain_findings,
    period_ticks,
)
from frictionloop.quantities.protocol_schema import firmware_folder

CARRIER_HZ = 132e6 / 2870
"""Of an image for the bench."""


def at(frequency_hz, q=230.0):
    return fl.bench().evolve({"plate.frequency_hz": frequency_hz, "plate.q": q})


def test_clock_and_usual_period_are_those_of_the_boards_source():
    text = (firmware_folder() / "boards/teensy41/carrier.c").read_text()
    assert float(re.search(r"(\d+) MHz / FL_CARRIER_TICKS", text)[1]) * 1e6 == BUS_HZ
    assert int(re.search(r"#define FL_CARRIER_TICKS (\d+)", text)[1]) == USUAL_TICKS == period_ticks(fl.bench())
    assert carrier_hz(fl.bench()) == CARRIER_HZ and period_ticks(fl.feasible()) == USUAL_TICKS


@given(st.floats(5e3, 150e3))
def test_no_other_whole_period_is_nearer_to_the_plate(frequency_hz):
    ticks = period_ticks(at(frequency_hz))
    off = [abs(BUS_HZ / frequency_hz - each) for each in (ticks - 1, ticks, ticks + 1)]
    assert min(off) == off[1]


def test_a_plate_that_the_timer_cannot_reach_is_refused():
    with pytest.raises(fl.FrictionloopError, match=r"plate.frequency_hz = 1000 Hz: must be 4029 to") as refused:
        period_ticks(at(1000.0))
    (found,) = board_findings(at(1000.0))
    assert found.code == refused.value.code and found.more["share"] < 5.0


def test_what_is_left_is_the_response_of_a_resonator_beside_its_peak():
    plate = fl.ResonantPlate(frequency_hz=45000.0, q=230.0)
    # An independent form: |1 / (1 - x^2 + j x / Q)| over its value Q at the resonance, x = f / f0.
    x = CARRIER_HZ / plate.frequency_hz
    resonator = abs(1.0 / (1.0 - x**2 + 1j * x / plate.q)) / plate.q
    assert amplitude_left(plate, CARRIER_HZ) == pytest.approx(resonator, rel=0.03)
    assert amplitude_left(fl.ResonantPlate(frequency_hz=CARRIER_HZ), CARRIER_HZ) == 1.0
    at_corner = fl.ResonantPlate(frequency_hz=CARRIER_HZ / (1.0 - 1.0 / 460.0), q=230.0)
    assert amplitude_left(at_corner, CARRIER_HZ) == pytest.approx(np.sqrt(0.5), rel=0.01)


def test_another_rate_and_a_plate_between_two_carriers_are_found_and_the_bench_is_not():
    assert [*board_findings(fl.bench())] == [*board_findings(fl.feasible())] == []
    (rate,) = board_findings(at(38200.0).evolve({"controller.rate_hz": 4400.0}))
    assert (rate.code, rate.value, rate.limit) == ("BOARD-RATE", 4400.0, 4000.0)
    between = at(BUS_HZ / 942.4, q=2000.0)
    (plate,) = gain_findings(between)
    share = amplitude_left(between.plate, BUS_HZ / 942)
    assert (plate.code, plate.severity, plate.limit) == ("BOARD-CARRIER", "warning", BUS_HZ / 942)
    assert plate.more["share"] == pytest.approx(100 * share) == pytest.approx(50.7, abs=0.1)
    assert plate.remedy["plate.pulse_ticks"] == 942
    assert plate.remedy["plate.max_amplitude_um"] == pytest.approx(share * between.plate.max_amplitude_um, rel=1e-3)
    (known,) = board_findings(between.evolve({"plate.pulse_ticks": 942}))
    assert (known.code, known.severity, known.remedy) == ("BOARD-CARRIER", "note", "")


def test_strokes_that_the_position_sensor_cannot_follow_are_found_with_a_scale_that_can():
    far = fl.bench().evolve({"motion.stroke_mm": 80.0})
    (found,) = board_findings(far)
    assert (found.code, found.value) == ("BOARD-POSITION", 40.0) and found.limit == pytest.approx(32.767)
    assert [*board_findings(far.evolve(found.remedy))] == []


def test_steps_are_found_which_a_table_of_points_has_not():
    levels = {"kind": "steps", "times_s": (0.0, 1.0), "levels_n": (0.4, 0.6)}
    (found,) = board_findings(fl.bench().evolve({"setpoint": levels}))
    assert (found.code, found.limit, found.value) == ("BOARD-STEPS", 1024, pytest.approx(0.2, rel=0.03))
    assert [*board_findings(fl.bench().evolve({"setpoint": levels | {"times_s": (0.0,), "levels_n": (0.4,)}}))] == []


def test_converters_that_are_coarser_than_the_files_are_found_with_the_bits_that_they_have():
    (found,) = converter_findings(fl.bench())
    assert (found.code, found.value, found.limit) == ("BOARD-BITS", 16, 12)
    assert [*converter_findings(fl.bench().evolve(found.remedy))] == [*converter_findings(fl.feasible())] == []


@pytest.mark.parametrize(("ceiling_um", "reached"), [(0.3, False), (1.1, False), (2.0, True), (None, True)])
def test_a_ceiling_is_found_that_leaves_forces_out(ceiling_um, reached):
    system = fl.bench().evolve({"setpoint.offset_n": 0.55, "setpoint.amplitude_n": 0.05})
    found = [*ceiling_findings(system if ceiling_um is None else system.evolve({"board.ceiling_um": ceiling_um}))]
    if ceiling_um is None:
        assert [(each.code, each.remedy) for each in found] == [("FIRST-RUN", {"board.ceiling_um": 0.5})]
        return
    friction = system.friction
    least_n = float(friction.nominal_n * np.exp(-friction.susceptibility_per_um2 * ceiling_um**2))
    assert (least_n <= 0.5) is reached
    assert [each.limit for each in found] == ([] if reached else [pytest.approx(least_n)])
