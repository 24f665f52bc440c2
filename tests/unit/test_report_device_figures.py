"""Fig. 3 as a drawing of a SensorDesign."""

from __future__ import annotations

import pytest

from frictionloop.figures.style import svg
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.report.schematics import figure_sensor


def words(figure):
    return "\n".join(text.get_text() for axes in figure.axes for text in axes.texts)


def test_the_schematic_shows_the_designs_own_numbers():
    drawn = words(figure_sensor(SensorDesign()))
    for shown in (
        "0.4 kg",
        "145 Hz",
        "100 µm",
        "200 mm²",
        "22 pF",
        "10 MΩ",
        "120 kHz",
        "Q 4",
        "1 kHz",
        "16 bit",
        "±2.5 N",
    ):
        assert shown in drawn, shown


@pytest.mark.parametrize(
    ("change", "shown"),
    [
        ({"electrodes.gap_um": 150.0}, "150 µm"),
        ({"moving.mass_kg": 1.2}, "1.2 kg"),
        ({"amplifier.feedback_pf": 47.0}, "47 pF"),
        ({"adc.bits": 18}, "18 bit"),
        ({"filters.cutoff_hz": 300.0}, "0.3 kHz"),
        ({"readout.form": "ratio"}, "÷"),
        ({"springs.angle_deg": 90.0}, "90°"),
    ],
)
def test_the_schematic_changes_with_the_design(change, shown):
    before, after = figure_sensor(SensorDesign()), figure_sensor(SensorDesign().evolve(change))
    assert shown in words(after) and shown not in words(before)
    assert svg(before, "x") != svg(after, "x")


def test_springs_turned_alike_are_drawn_alike():
    around = figure_sensor(SensorDesign())
    parallel = figure_sensor(SensorDesign().evolve({"springs.arrangement": "parallel"}))
    assert svg(around, "x") != svg(parallel, "x")
