"""What a builder is told: the parts agree with each other, and the command prints them."""

from __future__ import annotations

import json
import math

import pytest
from cyclopts import App

from frictionloop.cli.design_plate import ARGUMENTS, EXAMPLES, command
from frictionloop.cli.flags import gather
from frictionloop.hardware.plate.answers import plate_answers, plate_for
from frictionloop.parameters.plate_design import PlateDesign
from frictionloop.quantities import FrictionloopError

PAPER = PlateDesign().evolve({"drive.resonance_hz": 46e3})


@pytest.fixture
def plate(capsys):
    """Return a function that calls the command as the program does."""
    app = App(name="plate", default_parameter=None)
    app.default(command)

    def run(*tokens):
        app(gather(list(tokens)), print_error=False, exit_on_error=False, result_action="return_value")
        return capsys.readouterr().out

    return run


def test_the_printed_frequency_and_amplitude():
    found = plate_answers(PAPER)
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
    fine = plate_answers(PAPER).electronics
    coarse = plate_answers(PAPER.evolve({"carrier.timer_hz": 1.2e6})).electronics
    for each in (fine, coarse):
        curve = 1 / math.sqrt(1 + (2 * each.detuning_hz / (46e3 / 230)) ** 2)
        assert each.detuned_gain == pytest.approx(curve, rel=1e-12)
    assert coarse.ticks == 26
    assert coarse.detuned_gain < fine.detuned_gain


def test_more_q_takes_less_power_and_bandwidth_in_proportion():
    low, high = (plate_answers(PAPER.evolve({"drive.quality_factor": q})) for q in (230.0, 460.0))
    assert low.effort.power_w == pytest.approx(2 * high.effort.power_w, rel=1e-12)
    assert low.vibration.bandwidth_hz == pytest.approx(2 * high.vibration.bandwidth_hz, rel=1e-12)
    assert high.finger.amplitude_on_touch < low.finger.amplitude_on_touch


def test_what_is_wanted_is_what_one_gets():
    wanted = plate_for(PAPER, frequency_hz=40e3, bandwidth_hz=150.0)
    changed = PAPER.evolve({"geometry.thickness_mm": wanted.thickness_mm, "drive.resonance_hz": None})
    changed = changed.evolve({"drive.quality_factor": wanted.quality_factor})
    got = plate_answers(changed).vibration
    assert got.resonance_hz == pytest.approx(40e3, rel=1e-9)
    assert got.bandwidth_hz == pytest.approx(150.0, rel=1e-9)
    assert wanted.nearest.nodal_lines == 11  # 39.08 kHz in the table of the research notes, E
    nothing = plate_for(PAPER)
    assert nothing.nearest is None
    assert math.isnan(nothing.thickness_mm)
    assert math.isnan(nothing.quality_factor)


def test_the_command_prints_json(plate):
    found = json.loads(plate("--drive.quality-factor", "150", "--drive.resonance_hz=46000", "--json"))
    assert found["design"]["drive"]["quality_factor"] == 150
    assert found["answers"]["vibration"]["bandwidth_hz"] == pytest.approx(46e3 / 300, rel=1e-12)
    assert found["wanted"] == {"nearest": None, "thickness_mm": None, "quality_factor": None}
    assert (found["readings"], found["carrier"]) == ([], [])
    found = json.loads(
        plate("--frequency-hz", "46000", "--bandwidth-hz=100", "--readings", "--check-carrier", "--json")
    )
    assert found["wanted"]["nearest"]["nodal_lines"] == 12
    assert found["wanted"]["quality_factor"] == 230
    assert sorted(each["agrees"] for each in found["readings"])[-1] == ["thickness", "lines"]
    assert all(each["largest"] <= each["allowed"] for each in found["carrier"])


def test_the_command_prints_a_summary(plate):
    text = plate("--frequency-hz", "46000", "--bandwidth-hz", "100", "--readings", "--check-carrier")
    for words in ("46.26 kHz", "12 lines on 140 mm", "nearest mode", "as printed: thickness, frequency", "band-pass"):
        assert words in text
    assert "as printed" not in plate()


@pytest.mark.parametrize(("hz", "unit", "mm"), [("46000", "mm", 1.0), ("1700", "mm", 1.0), ("1660", "um", 1e-3)])
def test_a_thickness_is_printed_in_its_unit(plate, hz, unit, mm):
    asked = ("--frequency-hz", hz, "--geometry.nodal-lines", "12")
    (row,) = (line.split() for line in plate(*asked).splitlines() if line.startswith("thickness"))
    told = json.loads(plate(*asked, "--json"))["wanted"]["thickness_mm"]
    assert row[2] == unit
    assert float(row[1]) * mm == pytest.approx(told, rel=5e-3)


def test_the_examples_run(plate):
    calls = [line.split("design plate", 1)[1].split() for line in EXAMPLES.splitlines() if "design plate" in line]
    assert len(calls) > 2
    for call in calls:
        assert plate(*call)
    assert ARGUMENTS


@pytest.mark.parametrize(
    "tokens, said",
    [
        (("--drive.quality-factor", "0"), "drive.quality_factor = 0: must be greater than 0.5"),
        (("--geometry.nodal-lines", "60"), "nodal_lines = 60: must be a whole number from 2 to 47"),
        (("--geometry.thick", "3"), "unknown parameter 'geometry.thick'; did you mean geometry.thickness_mm"),
        (("--frequency-hz", "1e6"), "frequency_hz = 1e+06 Hz: must be at most"),
        (("--bandwidth-hz", "0"), "bandwidth_hz = 0.0 Hz: must be a finite number above 0"),
        (("--carrier.timer-hz", "1000"), "timer_hz = 1000 Hz: must be at least"),
    ],
)
def test_bad_input_is_one_line(plate, tokens, said):
    with pytest.raises(FrictionloopError) as error:
        plate(*tokens)
    assert str(error.value).startswith(said)
    assert "\n" not in str(error.value)


def test_a_wanted_frequency_is_answered_at_its_nearest_mode(plate):
    found = json.loads(plate("--frequency-hz", "38000", "--json"))
    mode = found["answers"]["vibration"]["mode"]
    assert mode == found["wanted"]["nearest"] and found["design"]["geometry"]["nodal_lines"] == mode["nodal_lines"]
    off = abs(mode["frequency_hz"] / 38000 - 1)
    assert f"{100 * off:.2g} % above the 38.00 kHz asked for" in " ".join(plate("--frequency-hz", "38000").split())
    given = json.loads(plate("--frequency-hz", "38000", "--geometry.nodal-lines", "12", "--json"))
    assert given["answers"]["vibration"]["mode"]["nodal_lines"] == 12
