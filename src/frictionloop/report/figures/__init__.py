"""The figures: each a function from computed data to a matplotlib Figure."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

from matplotlib.figure import Figure

from frictionloop.parameters import paper
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.report.claims.steps import this_skin_limit_ms
from frictionloop.report.device import CLOSED
from frictionloop.report.figures.beyond import figure_close_steps
from frictionloop.report.figures.calibration import figure_linearity, figure_spectrum
from frictionloop.report.figures.closed_loop import figure_closed_loop, figure_people
from frictionloop.report.figures.comparison import figure_residuals
from frictionloop.report.figures.diagram import figure_diagram
from frictionloop.report.figures.equation3 import figure_equation_3
from frictionloop.report.figures.fidelity import figure_fidelity_map, figure_fidelity_over_kp
from frictionloop.report.figures.noise import figure_noise
from frictionloop.report.figures.population import figure_population
from frictionloop.report.figures.sensor import figure_sensor
from frictionloop.report.figures.steps import figure_overshoot, figure_steps
from frictionloop.report.figures.tracking import common_limits_n, figure_tracking
from frictionloop.report.results import Results
from frictionloop.report.systems import FEASIBLE, WORKING
from frictionloop.report.tracking import KPS

SHORT = {WORKING: "printed", FEASIBLE: "reachable"}
"""What file names call the two systems that have figures of their own."""


class Drawing(NamedTuple):
    """A figure of the report: its file name without suffix, what it shows in words, and how to draw it."""

    name: str
    alt: str
    draw: Callable[[], Figure]


def drawings(results: Results) -> Iterator[Drawing]:
    """Yield every figure in the order of the page."""
    yield Drawing(
        "fig-1a",
        "Friction force against vibration amplitude for 26 synthetic trials",
        partial(figure_population, results.population, paper().friction),
    )
    yield Drawing("fig-1b", "Block diagram of the closed loop with its parameters", partial(figure_diagram, paper()))
    for name, fidelity in results.maps.items():
        alt = f"Map of fidelity over both gains, {name}"
        yield Drawing(f"fig-2a-{SHORT[name]}", alt, partial(figure_fidelity_map, fidelity, name))
    yield Drawing(
        "fig-2a-readings",
        "Fidelity over the proportional gain for each reading of the amplitudes",
        partial(figure_fidelity_over_kp, results.over_kp),
    )
    yield from _tracking(results)
    yield from _noise(results)
    yield Drawing(
        "fig-equation-3",
        "Noise of force and command over sensor noise, against the proportional gain",
        partial(figure_equation_3, results.steady),
    )
    yield from _device(results)
    yield from _beyond(results)


def _device(results: Results) -> Iterator[Drawing]:
    sensor, rigs = partial(figure_sensor, SensorDesign()), results.rigs
    yield Drawing("fig-3", "Schematic of the force sensor: frame, springs, electrodes and electronics", sensor)
    yield Drawing("fig-4a", "Reading against weight, two rigs, with residuals", partial(figure_linearity, rigs))
    yield Drawing("fig-4b", "Response to a hammer and noise over frequency", partial(figure_spectrum, rigs))
    alt = "Friction force against set-point in open loop and under three controllers"
    yield Drawing("fig-5a", alt, partial(figure_closed_loop, results.tracked))
    alt = "Error of 26 fingers in open loop and under two controllers"
    yield Drawing("fig-5a-population", alt, partial(figure_people, results.people))
    steps = partial(figure_steps, results.stepped, {"rising": this_skin_limit_ms()})
    yield Drawing("fig-5b", "Steps of the set-point over time, and the times of the responses", steps)
    close = partial(figure_overshoot, results.stepped, CLOSED)
    yield Drawing("fig-5c", "Mean force and amplitude around falling and rising steps", close)


def _beyond(results: Results) -> Iterator[Drawing]:
    found = results.beyond
    alt = "Residual of the capable fingers under each control law, median and deciles, for both contacts"
    yield Drawing("beyond-residuals", alt, partial(figure_residuals, found.scored))
    alt = "Steps of the force on one finger, per control law, for both contacts"
    yield Drawing("beyond-steps", alt, partial(figure_close_steps, found.steps))


def _tracking(results: Results) -> Iterator[Drawing]:
    for name, short in SHORT.items():
        runs = results.runs[name]
        limits_n = common_limits_n(list(runs.values()))
        for kp, letter in zip(KPS, "bcd", strict=True):
            alt = f"Force against set-point, and both over time, at Kp = {kp:g}, {name}"
            yield Drawing(f"fig-2{letter}-{short}", alt, partial(figure_tracking, runs[kp], kp, limits_n))


def _noise(results: Results) -> Iterator[Drawing]:
    draw = partial(figure_noise, {name: results.noise[name] for name in SHORT})
    fidelity = partial(draw, "r2_identity", "fidelity $R^2$", (-0.7, 1.02), "bottom")
    saturation = partial(draw, "saturation_index", "saturation index", (0.0, 1.02), "top")
    yield Drawing("fig-2e", "Fidelity against sensor noise", fidelity)
    yield Drawing("fig-2f", "Saturation index against sensor noise", saturation)
