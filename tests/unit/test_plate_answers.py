"""What a builder is told of a plate: the parts agree with each other."""

from __future__ import annotations

import math
import tomllib

import pytest

import frictionloop as fl
from frictionloop.hardware.plate.plate_answers import plate, plate_for
from frictionloop.parameters.plate_design import PlateDesign
from frictionloop.quantities import FrictionloopError

PAPER = PlateDesign().evolve({"drive.resonance_hz": 46e3})


def test_the_printed_frequency_and_amplitude():
    found = plate(PAPER)
    assert found.vibration.bandwidth_hz == pytest.approx(100.0, rel=1e-13)
    assert found.electronics.levels == 391
    assert found.electronics.carrier_hz == 36e6 / 783
    assert found.electronics.detuning_hz == pytest.approx(36e6 / 783 - 46e3, rel=1e-9)
    assert found.electronics.longest_wait_s == 783 / 36e6
    effort = found.effort
    assert effort.power_w == pytest.approx(44, abs=0.5)  # research notes, C.6
    assert effort.voltage_v * effort.force_n_per_v * found.electronics.detuned_gain == pytest.approx(effort.force_n)


def test_a_timer_that_misses_the_resonance_costs_amplitude():
    """1/sqrt(1 + (2 df/(f0/Q))^2) of a resonance curve, and a thirtieth of the ticks misses more."""
    fine = plate(PAPER).electronics
    coarse = plate(PAPER.evolve({"carrier.timer_hz": 1.2e6})).electronics
    for each in (fine, coarse):
        curve = 1 / math.sqrt(1 + (2 * each.detuning_hz / (46e3 / 230)) ** 2)
        assert each.detuned_gain == pytest.approx(curve, rel=1e-12)
    assert coarse.ticks == 26
    assert coarse.detuned_gain < fine.detuned_gain


def test_more_q_takes_less_power_and_bandwidth_in_proportion():
    low, high = (plate(PAPER.evolve({"drive.quality_factor": q})) for q in (230.0, 460.0))
    assert low.effort.power_w == pytest.approx(2 * high.effort.power_w, rel=1e-12)
    assert low.vibration.bandwidth_hz == pytest.approx(2 * high.vibration.bandwidth_hz, rel=1e-12)
    assert high.finger.amplitude_on_touch < low.finger.amplitude_on_touch


def test_what_is_wanted_is_what_one_gets():
    wanted = plate_for(PAPER, frequency_hz=40e3, bandwidth_hz=150.0)
    changed = PAPER.evolve({"geometry.thickness_mm": wanted.thickness_mm, "drive.resonance_hz": None})
    changed = changed.evolve({"drive.quality_factor": wanted.quality_factor})
    got = plate(changed).vibration
    assert got.resonance_hz == pytest.approx(40e3, rel=1e-9)
    assert got.bandwidth_hz == pytest.approx(150.0, rel=1e-9)
    assert wanted.nearest.nodal_lines == 11  # 39.08 kHz in the table of the research notes, E
    nothing = plate_for(PAPER)
    assert nothing.nearest is None
    assert math.isnan(nothing.thickness_mm)
    assert math.isnan(nothing.quality_factor)


def test_a_wanted_frequency_is_answered_at_its_nearest_mode():
    found = plate(frequency_hz=38e3)
    assert found.vibration.mode == found.wanted.nearest
    assert found.design.geometry.nodal_lines == found.wanted.nearest.nodal_lines != 12
    assert plate(overrides={"geometry.nodal_lines": 12}, frequency_hz=38e3).vibration.mode.nodal_lines == 12


def test_the_block_is_that_with_a_finger_on_and_a_bench_of_the_loop():
    found = plate()
    shown = str(found)
    block = tomllib.loads(shown[shown.index("[plate]") :])["plate"]
    bench = fl.bench().evolve({"plate": block})
    assert bench.plate.q == pytest.approx(found.finger.quality_on_touch, rel=1e-5)
    assert bench.plate.max_amplitude_um == pytest.approx(2.5 * found.finger.amplitude_on_touch, rel=1e-5)


def test_figures_with_a_finger_on_are_those_of_the_plate_that_a_finger_makes_so():
    """Measured with the finger on: the Q and the amplitude of the block, whose bare plate is the one they came from."""
    bare = plate()
    touched = {"quality_factor": bare.plate["q"], "max_amplitude_um": bare.plate["max_amplitude_um"]}
    on = plate(overrides={"drive.finger_on": True, **{f"drive.{name}": value for name, value in touched.items()}})
    assert on.plate == pytest.approx(bare.plate) and on.effort.voltage_v == pytest.approx(bare.effort.voltage_v)
    assert on.design.drive.quality_factor == pytest.approx(230.0)
    with pytest.raises(FrictionloopError, match=r"drive\.quality_factor = 2000: must be below \d+, or"):
        plate(overrides={"drive.finger_on": True, "drive.quality_factor": 2000.0})


def test_a_carrier_outside_the_band_or_beside_the_resonance_is_a_finding():
    assert plate().findings == ()
    (band,) = plate(overrides={"carrier.band_high_hz": 30e3}).findings
    assert (band.code, band.more["high"]) == ("CARRIER-BAND", 30.0) and band.limit < 0.5
    (off,) = plate(overrides={"drive.quality_factor": 2000.0}).findings
    assert off.code == "CARRIER-OFF" and off.value == pytest.approx(plate().electronics.detuning_hz)


def test_readings_and_the_simulated_carrier_stand_where_they_are_asked_for():
    found = plate(frequency_hz=46e3, bandwidth_hz=100.0, readings=True, check_carrier=True)
    assert (found.wanted.nearest.nodal_lines, found.wanted.quality_factor) == (12, 230)
    assert sorted(each.agrees for each in found.readings)[-1] == ("thickness", "lines")
    assert all(each.largest <= each.allowed for each in found.carrier)
    assert {"block", "figures"} == set(found.tables()) - {"the paper's plate", "off the first-order envelope, %"}
    assert (plate().readings, plate().carrier) == ((), ())


@pytest.mark.parametrize(
    ("overrides", "asked", "said"),
    [
        ({"drive.quality_factor": 0}, {}, "drive.quality_factor = 0: must be greater than 0.5"),
        ({"geometry.nodal_lines": 60}, {}, "nodal_lines = 60: must be whole, 2 to 47"),
        ({"geometry.thick": 3}, {}, "unknown parameter 'geometry.thick'; did you mean geometry.thickness_mm"),
        ({}, {"frequency_hz": 1e6}, "frequency_hz = 1e+06 Hz: must be at most"),
        ({}, {"bandwidth_hz": 0.0}, "bandwidth_hz = 0 Hz: must be finite and above 0"),
        ({"carrier.timer_hz": 1000.0}, {}, "timer_hz = 1000 Hz: must be at least"),
    ],
)
def test_bad_input_is_one_line(overrides, asked, said):
    with pytest.raises(FrictionloopError) as error:
        plate(overrides=overrides, **asked)
    assert str(error.value).startswith(said)
    assert "\n" not in str(error.value)
