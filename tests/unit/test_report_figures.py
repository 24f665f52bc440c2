"""Figures that need no simulation: the block diagram, the sensor, the population, and the style they share."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl
from frictionloop import report
from frictionloop.figures.style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILLION, inline, svg
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.report.number_text import number
from frictionloop.report.schematics import controller_label, figure_diagram, figure_sensor, lookup_label, source_label
from frictionloop.report.system_comparison import binned, figure_population, sliding_trials


def words(figure):
    return "\n".join(text.get_text() for axes in figure.axes for text in axes.texts)


DIAGRAM = (figure_diagram, fl.paper())
SENSOR = (figure_sensor, SensorDesign())


@pytest.mark.parametrize(
    ("drawn", "shown"),
    [
        (DIAGRAM, "= 10; = 2 s⁻¹; 5 kHz; 0.8 N; 0.38; 100 Hz; 1000 Hz; 10⁻⁵ N; 0.6 ± 0.6"),
        (SENSOR, "0.4 kg; 145 Hz; 100 µm; 200 mm²; 22 pF; 10 MΩ; 120 kHz; Q 4; 1 kHz; 16 bit; ±2.5 N"),
    ],
)
def test_a_scheme_shows_its_own_numbers(drawn, shown):
    draw, system = drawn
    text = words(draw(system))
    assert [each for each in shown.split("; ") if each not in text] == []


@pytest.mark.parametrize(
    ("drawn", "change", "shown"),
    [
        (DIAGRAM, {"controller.kp": 7.5}, "7.5"),
        (DIAGRAM, {"controller.delay_s": 2e-4}, "delay 200 µs"),
        (DIAGRAM, {"controller.model.table_size": 256}, "256 entries"),
        (DIAGRAM, {"controller.model.nominal_n": 1.25}, "1.25 N"),
        (DIAGRAM, {"plate.cutoff_hz": 150.0}, "150 Hz"),
        (DIAGRAM, {"friction.susceptibility_per_um2": 0.51}, "0.51"),
        (DIAGRAM, {"sensor.noise_rms_n": 3e-4}, "3×10⁻⁴ N"),
        (DIAGRAM, {"setpoint.stop_hz": 55.0}, "sweep 1–55 Hz"),
        (DIAGRAM, {"disturbance.frequency_hz": 3.0}, "sine 3 Hz"),
        (SENSOR, {"electrodes.gap_um": 150.0}, "150 µm"),
        (SENSOR, {"moving.mass_kg": 1.2}, "1.2 kg"),
        (SENSOR, {"amplifier.feedback_pf": 47.0}, "47 pF"),
        (SENSOR, {"adc.bits": 18}, "18 bit"),
        (SENSOR, {"filters.cutoff_hz": 300.0}, "0.3 kHz"),
        (SENSOR, {"readout.form": "ratio"}, "÷"),
        (SENSOR, {"springs.angle_deg": 90.0}, "90°"),
        (SENSOR, {"springs.arrangement": "parallel"}, ""),
    ],
)
def test_a_scheme_changes_with_what_it_shows(drawn, change, shown):
    draw, system = drawn
    before, after = draw(system), draw(system.evolve(change))
    assert shown in words(after) and (not shown or shown not in words(before))
    assert svg(before, "x") != svg(after, "x")


def test_blocks_of_the_diagram_do_not_overlap():
    axes = figure_diagram(fl.paper()).axes[0]
    boxes = [patch.get_bbox() for patch in axes.patches if patch.get_zorder() == 2 and hasattr(patch, "get_bbox")]
    for i, one in enumerate(boxes):
        assert not any(one.overlaps(other) for other in boxes[i + 1 :])


def test_labels():
    assert source_label(fl.paper().setpoint) == "sweep 1–100 Hz\n0.6 ± 0.6 N"
    assert controller_label(fl.paper().controller)[2] == "5 kHz, no delay"
    assert lookup_label(fl.paper().controller.model)[0] == "exact inverse of $g$"


def test_numbers_for_people():
    shown = {0.0: "0", 50000: "50000", 1.2e7: "1.2×10⁷"}  # and those of its docstring
    assert {value: number(value) for value in shown} == shown


def test_the_population_is_binned_over_all_trials():
    trials = sliding_trials(5)
    centres, mean, spread = binned(trials)
    assert centres[0] == pytest.approx(0.125)
    first = trials["f"].values[:, trials["a"].values < 0.25]
    assert mean[0] == pytest.approx(first.mean()) and spread[0] == pytest.approx(first.std())
    assert np.all(np.diff(mean) < 0)


def test_the_population_figure_says_that_it_is_synthetic():
    figure = figure_population(sliding_trials(3), fl.paper().friction)
    assert figure.axes[0].get_title(loc="left") == "3 synthetic sliding trials"


def test_svg_ids_carry_the_figures_name():
    text = svg(figure_diagram(fl.paper()), "fig-x")
    assert all(found.startswith("fig-x-") for found in re.findall(r'\bid="([^"]+)"', text))
    referred = set(re.findall(r'(?:href="#|url\(#)([^")]+)', text))
    assert referred <= set(re.findall(r'\bid="([^"]+)"', text))


def test_an_inline_figure_has_a_label_and_no_fixed_size():
    element = inline(svg(figure_diagram(fl.paper()), "fig-x"), 'the "loop"')
    opening = element[: element.index(">")]
    assert opening.startswith("<svg") and 'aria-label="the &quot;loop&quot;"' in opening
    assert " width=" not in opening and " height=" not in opening
    # The page's style is told the width that the letters were drawn for: the width of the view box, in points.
    assert re.search(r"--pt:([\d.]+)", opening)[1] == re.search(r'viewBox="0 0 ([\d.]+)', opening)[1]


def test_colours_differ_in_grey_or_by_their_dashes():
    def lightness(colour):
        red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    shades = sorted(lightness(colour) for colour in (BLUE, VERMILLION, GREEN, ORANGE, SKY, PURPLE))
    assert shades[-1] - shades[0] > 60


def test_no_figure_is_a_white_card_on_a_dark_page():
    style = (Path(report.__file__).parent / "templates" / "style.css").read_text()
    dark = style.partition("prefers-color-scheme: dark")[2].partition("\n}")[0]
    assert 'svg[aria-label^="Map"]' in dark and "#fff" not in dark
