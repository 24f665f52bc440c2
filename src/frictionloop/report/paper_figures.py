"""The figures by name: how each is drawn from the results, and the numbers that it stands for."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from matplotlib.figure import Figure

from frictionloop.design.comparison.law_figures import figure_residuals, figure_step_traces
from frictionloop.loop.metrics import r2_bound, r2_identity, rms_error, saturation_index
from frictionloop.parameters import paper
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.report.claims.claim import Value
from frictionloop.report.closed_loop import Table, figure_closed_loop, figure_people, strokes
from frictionloop.report.control_law_study import MEDIAN, SHOWN_MS, SPEED_MM_S, WORST
from frictionloop.report.effect_arrivals import figure_arrivals
from frictionloop.report.gain_maps import (
    PAPER_POINT,
    at_paper,
    figure_fidelity_map,
    figure_fidelity_over_kp,
    optimum,
    useful_range,
)
from frictionloop.report.paper_protocol import CLOSED, CONTROLLERS, IDEAL, OPEN, POPULATION, PRINTED, RETUNED_GAINS
from frictionloop.report.results import Results
from frictionloop.report.rig_characterisation import figure_linearity, figure_spectrum
from frictionloop.report.schematics import figure_diagram, figure_sensor
from frictionloop.report.sensor_noise import LEVELS_N, figure_equation_3, figure_noise
from frictionloop.report.step_response import (
    DIRECTIONS,
    figure_overshoot,
    figure_steps,
    overshoot,
    this_skin_limit_ms,
    times_ms,
)
from frictionloop.report.system_comparison import (
    FEASIBLE,
    KPS,
    WORKING,
    common_limits_n,
    figure_population,
    figure_tracking,
)

SHORT = {"printed": WORKING, "reachable": FEASIBLE}
"""What file names call the two systems that have figures of their own."""


def _map(name: str, results: Results) -> Figure:
    return figure_fidelity_map(results.maps[name], name)


def _tracking(name: str, kp: float, results: Results) -> Figure:
    runs = results.runs[name]
    return figure_tracking(runs[kp], kp, common_limits_n(list(runs.values())))


def _strokes(names: tuple[str, ...], results: Results) -> Figure:
    return figure_closed_loop(results.tracked, names, strokes(names, results))


def _over_noise(metric: str, label: str, limits: tuple[float, float], words: str, results: Results) -> Figure:
    return figure_noise({name: results.noise[name] for name in SHORT.values()}, metric, label, limits, words)


def _map_numbers(name: str, results: Results) -> Table:
    fidelity = results.maps[name]
    best, (kp, ki) = optimum(fidelity["r2_identity"]), PAPER_POINT
    bound = float(fidelity["r2_bound"])
    return {
        "largest of the map": {"kp": best.kp, "ki": best.ki, "r2_identity": best.r2, "r2_bound": bound},
        "the paper's": {"kp": kp, "ki": ki, "r2_identity": at_paper(fidelity["r2_identity"]), "r2_bound": bound},
    }


def _cuts(results: Results) -> Table:
    found: Table = {}
    for name, cut in results.over_kp.items():
        best, useful = optimum(cut["r2_identity"]), useful_range(cut["r2_identity"])
        scores = {"r2_identity": best.r2, "r2_bound": float(cut["r2_bound"])}
        found[name] = {"kp_of_largest": best.kp, "kp_useful_from": useful.low, "kp_useful_to": useful.high, **scores}
    return found


def _tracking_numbers(name: str, kp: float, results: Results) -> Table:
    run = results.runs[name][kp]
    metrics = {"r2_identity": r2_identity, "r2_bound": r2_bound, "error_n": rms_error}
    found: dict[str, Value] = {key: float(metric(run)) for key, metric in metrics.items()}
    return {f"kp {kp:g}, {name}": found | {"saturation_index": saturation_index(run)}}


def _noise_numbers(metric: str, results: Results) -> Table:
    medians = {name: results.noise[name][metric].median("seed") for name in SHORT.values()}
    return {
        f"{level_n:.2g} N rms": {name: float(median.sel(sigma=level_n)) for name, median in medians.items()}
        for level_n in LEVELS_N[::8]  # one for each decade
    }


def _equation_3(results: Results) -> Table:
    steady = results.steady
    simulated = {"force_over_noise": "simulated_f", "command_over_noise": "simulated_u"}
    found: Table = {
        f"kp {float(kp):g}": {key: float(steady[name].sel(kp_simulated=kp)) for key, name in simulated.items()}
        for kp in steady["kp_simulated"].values
    }
    found["linear loop"] = {"kp_limit": float(steady["kp_limit"])}
    return found


def _linearity(results: Results) -> Table:
    rigs = {"pulley on ball bearings": results.rigs.weights, "string that rubs": results.rigs.rubbing}
    return {name: {"r2": found.r2, "sensitivity": found.sensitivity.value} for name, found in rigs.items()}


def _spectrum(results: Results) -> Table:
    rigs, fitted = results.rigs, results.rigs.resonance
    found: Table = {"hammer": {"resonance_hz": fitted.resonance.value, "q": fitted.q.value}}
    for name in rigs.floors:
        found[name] = {"floor_n_rthz": rigs.density_n_rthz(name), "rms_n": rigs.rms_n(name)}
    return found


def _people(results: Results) -> Table:
    found: Table = {}
    for name in (OPEN, PRINTED, RETUNED_GAINS):
        some = results.people[name]
        able = some.where(some["capable"], drop=True)
        for words, group in {f"{POPULATION} fingers": some, "the capable": able}.items():
            found[f"{name}, median of {words}"] = {
                "r2_regression": float(group["r2_regression"].median()),
                "spread_n": float(group["spread_n"].median()),
                "spread_divided_by": float((results.people[OPEN]["spread_n"] / group["spread_n"]).median()),
                "error_n": float(group["error_n"].median()),
                "fingers": float(group.sizes["finger"]),
            }
    return found


def _steps(results: Results) -> Table:
    found: Table = {}
    for name in CONTROLLERS:
        for direction in DIRECTIONS:
            times = times_ms(results.stepped[name], name, direction)
            told = {"to_63_ms": times.to_63, "from_10_to_90_ms": times.from_10_to_90, "steps": float(times.steps)}
            found[f"{name}, {direction}"] = told
    return found


def _overshoot(results: Results) -> Table:
    over = {name: {each: overshoot(results.stepped[name], each) for each in DIRECTIONS} for name in CLOSED}
    return {name: {f"overshoot_{each}": value for each, value in some.items()} for name, some in over.items()}


def _residuals(results: Results) -> Table:
    study = results.beyond
    return {
        f"{law}, {contact}": {f"{key}_n": study.value(law, contact, "residual_rms_n", key) for key in (MEDIAN, WORST)}
        for law, contact in study.cells
    }


class PaperFigure(NamedTuple):
    """How a figure is drawn, and the numbers that it stands for: none of a scheme or of stored traces."""

    draw: Callable[[Results], Figure]
    numbers: Callable[[Results], Table] = lambda _: {}


FIGURES = {
    "fig-1a": PaperFigure(lambda results: figure_population(results.population, paper().friction)),
    "fig-1b": PaperFigure(lambda _: figure_diagram(paper())),
    **{
        f"fig-2a-{short}": PaperFigure(partial(_map, name), partial(_map_numbers, name))
        for short, name in SHORT.items()
    },
    "fig-2a-readings": PaperFigure(lambda results: figure_fidelity_over_kp(results.over_kp), _cuts),
    **{
        f"fig-2{letter}-{short}": PaperFigure(partial(_tracking, name, kp), partial(_tracking_numbers, name, kp))
        for short, name in SHORT.items()
        for kp, letter in zip(KPS, "bcd", strict=True)
    },
    "fig-2e": PaperFigure(
        partial(_over_noise, "r2_identity", "fidelity $R^2$", (-0.7, 1.02), "bottom"),
        partial(_noise_numbers, "r2_identity"),
    ),
    "fig-2f": PaperFigure(
        partial(_over_noise, "saturation_index", "saturation index", (0.0, 1.02), "top"),
        partial(_noise_numbers, "saturation_index"),
    ),
    "fig-equation-3": PaperFigure(lambda results: figure_equation_3(results.steady), _equation_3),
    "fig-3": PaperFigure(lambda _: figure_sensor(SensorDesign())),
    "fig-4a": PaperFigure(lambda results: figure_linearity(results.rigs), _linearity),
    "fig-4b": PaperFigure(lambda results: figure_spectrum(results.rigs), _spectrum),
    **{
        name: PaperFigure(partial(_strokes, some), partial(strokes, some))
        for name, some in {"fig-5a": (OPEN, RETUNED_GAINS), "fig-5a-printed": (PRINTED, IDEAL)}.items()
    },
    "fig-5a-population": PaperFigure(lambda results: figure_people(results.people), _people),
    "fig-5b": PaperFigure(lambda found: figure_steps(found.stepped, {"rising": this_skin_limit_ms()}), _steps),
    "fig-5c": PaperFigure(lambda results: figure_overshoot(results.stepped, CLOSED), _overshoot),
    "beyond-residuals": PaperFigure(lambda results: figure_residuals(results.beyond.scored), _residuals),
    "beyond-steps": PaperFigure(lambda found: figure_step_traces(found.beyond.steps, SPEED_MM_S, SHOWN_MS)),
    "beyond-arrivals": PaperFigure(lambda results: figure_arrivals(results.arrivals)),
}
"""By file name without suffix, in the order of the page."""
