"""Figures of a tournament: residuals of a population, steps of one finger, sensitivities."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from frictionloop.design.tournament import Tournament
from frictionloop.design.tournament.traces import sensitivities, step_traces
from frictionloop.report.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION, new_figure, styled

COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY, BLACK)
DASHES = ("-", (0, (4, 1.5)), (0, (1, 1)), (0, (6, 1.5, 1, 1.5)))
"""Lines change their dashes with every law, so that colour is never alone."""


def drawings(tournament: Tournament, scored: xr.Dataset) -> Iterator[tuple[str, str, Callable[[], Figure]]]:
    """Yield name, what it shows in words, and how to draw it, of each figure; steps and |S| need a capable finger."""
    laws, speed = list(tournament.laws), tournament.speeds_mm_s[0]
    yield "residuals", "Share of fingers against residual of each control law", partial(figure_residuals, scored)
    traces = step_traces(tournament, speed)
    if traces.sizes:
        yield "steps", "Steps of the force under each control law", partial(figure_step_traces, traces, speed)
    frequency_hz = np.geomspace(1.0, tournament.system.controller.rate_hz / 2.0, 600)
    if found := sensitivities(tournament, speed, frequency_hz):
        draw = partial(figure_sensitivities, frequency_hz, found, laws, speed)
        yield "sensitivity", "Sensitivity of each control law over frequency", draw


def line_of(laws: Sequence[str], law: str) -> dict[str, Any]:
    """Return colour and dashes of a law, the same in every figure of the same laws."""
    number = list(laws).index(law)
    return {"color": COLOURS[number % len(COLOURS)], "linestyle": DASHES[number % len(DASHES)]}


@styled
def figure_residuals(scored: xr.Dataset) -> Figure:
    """Return the share of capable fingers whose residual on the sines is at most so large, per speed and contact."""
    speeds, contacts, laws = (scored[name].values.tolist() for name in ("speed_mm_s", "contact", "law"))
    figure = new_figure(3.4 * len(contacts), 2.3 * len(speeds) + 0.5)
    grid = figure.subplots(len(speeds), len(contacts), squeeze=False, sharex=True, sharey=True)
    for v, speed in enumerate(speeds):
        some = scored["capable"].values[v]
        for axes, contact in zip(grid[v], contacts, strict=True):
            for law in laws:
                residual = 1e3 * scored["residual_rms_n"].sel(law=law, speed_mm_s=speed, contact=contact).values[some]
                if np.isfinite(residual).any():
                    axes.ecdf(residual[np.isfinite(residual)], label=law, **line_of(laws, law))
            axes.set(title=f"{contact}, {speed:g} mm/s, {some.sum()} fingers", xscale="log", ylim=(0.0, 1.0))
            axes.axhline(0.9, color=GREY, lw=0.6)
    _label(grid, "rms of $f_a - f_r$ on the sines (mN)", "share of capable fingers")
    legend_below(figure, grid[0, 0])
    return figure


@styled
def figure_step_traces(traces: xr.Dataset, speed_mm_s: float) -> Figure:
    """Return force over time on the median capable finger, the second second of a run, per contact."""
    contacts, laws = traces["contact"].values.tolist(), traces["law"].values.tolist()
    some = traces.sel(time=slice(0.9, None))
    figure = new_figure(6.8, 2.1 * len(contacts) + 0.5)
    grid = figure.subplots(len(contacts), 1, squeeze=False, sharex=True, sharey=True)
    for axes, contact in zip(grid[:, 0], contacts, strict=True):
        for law in laws:
            force = some["f_a"].sel(law=law, contact=contact)
            axes.plot(some["time"], force, label=law, lw=0.9, **line_of(laws, law))
        axes.plot(some["time"], some["f_r"].sel(law=laws[0], contact=contact), color=GREY, lw=0.8, label="set-point")
        axes.set(title=f"{contact}, {speed_mm_s:g} mm/s")
    _label(grid, "time (s)", "friction force (N)")
    legend_below(figure, grid[0, 0])
    return figure


@styled
def figure_sensitivities(
    frequency_hz: np.ndarray, found: Mapping[tuple[str, str], np.ndarray], laws: Iterable[str], speed_mm_s: float
) -> Figure:
    """Return |S| over frequency on the median capable finger around 0.6 N, per contact."""
    names = list(laws)
    contacts = list(dict.fromkeys(contact for _, contact in found))
    figure = new_figure(3.4 * len(contacts), 3.2)
    grid = figure.subplots(1, len(contacts), squeeze=False, sharey=True)
    for axes, contact in zip(grid[0], contacts, strict=True):
        for (law, at), size in found.items():
            if at == contact:
                axes.loglog(frequency_hz, size, label=law, **line_of(names, law))
        axes.axhline(1.0, color=GREY, lw=0.6)
        axes.set(title=f"{contact}, {speed_mm_s:g} mm/s", ylim=(1e-3, 30.0))
    _label(grid, "frequency (Hz)", "$|S|$, residual over disturbance")
    legend_below(figure, grid[0, 0])
    return figure


def _label(grid: Any, across: str, up: str) -> None:
    for axes in grid[-1]:
        axes.set_xlabel(across)
    for axes in grid[:, 0]:
        axes.set_ylabel(up)


def legend_below(figure: Figure, axes: Axes) -> None:
    """Put one legend for all panels under a figure."""
    handles, labels = axes.get_legend_handles_labels()
    if not labels:  # nobody to draw
        return
    rows = math.ceil(len(labels) / 4)  # more than four long names do not fit beside each other
    figure.legend(handles, labels, loc="outside lower center", ncols=math.ceil(len(labels) / rows))
