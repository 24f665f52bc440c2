"""The figures: each a function from the results to a matplotlib Figure."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from matplotlib.figure import Figure

from frictionloop.design.comparison.law_figures import figure_residuals, figure_step_traces
from frictionloop.parameters import paper
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.report.beyond import SHOWN_MS, SPEED_MM_S
from frictionloop.report.device import CLOSED, IDEAL, OPEN, PRINTED, RETUNED_GAINS
from frictionloop.report.figures.arrivals import figure_arrivals
from frictionloop.report.figures.calibration import figure_linearity, figure_spectrum
from frictionloop.report.figures.closed_loop import figure_closed_loop, figure_people
from frictionloop.report.figures.diagram import figure_diagram
from frictionloop.report.figures.fidelity import figure_fidelity_map, figure_fidelity_over_kp
from frictionloop.report.figures.noise import figure_equation_3, figure_noise
from frictionloop.report.figures.sensor import figure_sensor
from frictionloop.report.figures.steps import figure_overshoot, figure_steps
from frictionloop.report.figures.tracking import common_limits_n, figure_population, figure_tracking
from frictionloop.report.results import Results
from frictionloop.report.step_response import this_skin_limit_ms
from frictionloop.report.stroke_numbers import strokes
from frictionloop.report.systems import FEASIBLE, KPS, WORKING

SHORT = {"printed": WORKING, "reachable": FEASIBLE}
"""What file names call the two systems that have figures of their own."""


Draw = Callable[[Results], Figure]


def _map(name: str, results: Results) -> Figure:
    return figure_fidelity_map(results.maps[name], name)


def _tracking(name: str, kp: float, results: Results) -> Figure:
    runs = results.runs[name]
    return figure_tracking(runs[kp], kp, common_limits_n(list(runs.values())))


def _strokes(names: tuple[str, ...], results: Results) -> Figure:
    return figure_closed_loop(results.tracked, names, strokes(names, results))


def _over_noise(metric: str, label: str, limits: tuple[float, float], words: str, results: Results) -> Figure:
    return figure_noise({name: results.noise[name] for name in SHORT.values()}, metric, label, limits, words)


DRAWINGS: dict[str, Draw] = {
    "fig-1a": lambda results: figure_population(results.population, paper().friction),
    "fig-1b": lambda _: figure_diagram(paper()),
    **{f"fig-2a-{short}": partial(_map, name) for short, name in SHORT.items()},
    "fig-2a-readings": lambda results: figure_fidelity_over_kp(results.over_kp),
    **{
        f"fig-2{letter}-{short}": partial(_tracking, name, kp)
        for short, name in SHORT.items()
        for kp, letter in zip(KPS, "bcd", strict=True)
    },
    "fig-2e": partial(_over_noise, "r2_identity", "fidelity $R^2$", (-0.7, 1.02), "bottom"),
    "fig-2f": partial(_over_noise, "saturation_index", "saturation index", (0.0, 1.02), "top"),
    "fig-equation-3": lambda results: figure_equation_3(results.steady),
    "fig-3": lambda _: figure_sensor(SensorDesign()),
    "fig-4a": lambda results: figure_linearity(results.rigs),
    "fig-4b": lambda results: figure_spectrum(results.rigs),
    "fig-5a": partial(_strokes, (OPEN, RETUNED_GAINS)),
    "fig-5a-printed": partial(_strokes, (PRINTED, IDEAL)),
    "fig-5a-population": lambda results: figure_people(results.people),
    "fig-5b": lambda results: figure_steps(results.stepped, {"rising": this_skin_limit_ms()}),
    "fig-5c": lambda results: figure_overshoot(results.stepped, CLOSED),
    "beyond-residuals": lambda results: figure_residuals(results.beyond.scored),
    "beyond-steps": lambda results: figure_step_traces(results.beyond.steps, SPEED_MM_S, SHOWN_MS),
    "beyond-arrivals": lambda results: figure_arrivals(results.arrivals),
}
"""How each figure is drawn, by its file name without suffix, in the order of the page."""
