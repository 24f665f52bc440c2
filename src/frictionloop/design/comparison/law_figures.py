"""Figures of a comparison, and the first of them: residuals of a population."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from frictionloop.design.comparison.law_panels import figure_sensitivities, figure_step_traces
from frictionloop.design.comparison.margins import sensitivities, step_traces
from frictionloop.design.comparison.run import LawRuns
from frictionloop.design.comparison.scores import spread
from frictionloop.figures.style import BLACK, BLUE, new_figure, styled


def drawings(ran: LawRuns, scored: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Return how to draw each figure, by name; steps and |S| need a capable finger."""
    laws = list(ran.laws)
    found: dict[str, Callable[[], Figure]] = {"residuals": partial(figure_residuals, scored)}
    frequency_hz = np.geomspace(1.0, ran.system.controller.rate_hz / 2.0, 600)
    for speed in ran.speeds_mm_s:
        traces = step_traces(ran, speed)
        if traces.sizes:
            found[f"steps-{speed:g}-mm-s"] = partial(figure_step_traces, traces, speed)
        if sizes := sensitivities(ran, speed, frequency_hz):
            drawn = partial(figure_sensitivities, frequency_hz, sizes, laws, speed)
            found[f"sensitivity-{speed:g}-mm-s"] = drawn
    return found


@styled
def figure_residuals(scored: xr.Dataset) -> Figure:
    """Return the residual of the capable fingers on the sines, a row for each law: median, halves, deciles; in mN."""
    speeds, lengths, laws = (scored[name].values.tolist() for name in ("speed_mm_s", "slip_length_um", "law"))
    figure = new_figure(7.2, (0.21 * len(laws) + 0.45) * len(speeds) + 0.7)
    grid = figure.subplots(len(speeds), len(lengths), squeeze=False, sharex=True, sharey=True)
    for v, speed in enumerate(speeds):
        some = scored["capable"].values[v]
        for axes, z in zip(grid[v], lengths, strict=True):
            for row, law in enumerate(laws):
                cell = scored["residual_rms_n"].sel(law=law, speed_mm_s=speed, slip_length_um=z)
                _residual_row(axes, row, 1e3 * cell.values[some])
            axes.set(title=f"slip length {z:g} um, {speed:g} mm/s, {some.sum()} fingers", xscale="log")
            axes.grid(visible=False, axis="y")
    grid[0, 0].set_yticks(range(len(laws)), laws)
    grid[0, 0].set_ylim(len(laws) - 0.5, -0.5)
    for axes in grid[-1]:
        axes.set_xlabel("rms of $f_a - f_r$ on the sines (mN)")
    kinds = (
        Line2D([], [], color=BLACK, marker="o", ls="", label="median"),
        Line2D([], [], color=BLUE, lw=4.0, label="middle half of the fingers"),
        Line2D([], [], color=BLUE, lw=1.0, label="best to worst decile (numbers: median, worst decile)"),
    )
    figure.legend(handles=kinds, loc="outside lower center", ncols=len(kinds))
    return figure


def _residual_row(axes: Axes, row: int, residual: np.ndarray) -> None:
    there = residual[np.isfinite(residual)]
    if not there.size:
        return
    low, first, third = np.quantile(there, (0.1, 0.25, 0.75))
    median, worst = spread(there, larger_is_better=False)
    axes.plot([low, worst], [row, row], color=BLUE, lw=1.0)
    axes.plot([first, third], [row, row], color=BLUE, lw=4.0, solid_capstyle="butt")
    axes.plot(median, row, color=BLACK, marker="o")
    said = f"{_short(median)}, {_short(worst)}"
    axes.annotate(said, (1.0, row), (2, 0), ("axes fraction", "data"), "offset points", va="center", fontsize=7.0)


def _short(milli: float) -> str:
    return f"{milli:.2g}" if milli < 99.5 else f"{milli:.0f}"
