"""Figures of a comparison: residuals of a population, steps and sensitivity of each law."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from frictionloop.design.comparison.comparison_run import LawRuns
from frictionloop.design.comparison.comparison_scores import spread
from frictionloop.design.comparison.law_margins import sensitivities, step_traces
from frictionloop.design.comparison.trial_protocol import ORACLE, STEP_EVERY_S, STEP_LEVELS_N
from frictionloop.figures.style import BLACK, BLUE, GREY, ORANGE, SILVER, VERMILLION, new_figure, styled


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


STARTS_S = {"down": 2.0 * STEP_EVERY_S, "up": 3.0 * STEP_EVERY_S}
"""The second and the third step of the protocol."""
SHOWN_MS = {"down": (-2.0, 14.0), "up": (-5.0, 45.0)}
"""What is shown of each: how fast the force follows."""
ROOM_N = 0.3
"""How far the axis of the steps goes beyond the levels, N; what goes further is cut off, and said."""
COLUMNS = 3
"""Panels of |S| beside each other."""
LENGTH_LINES: tuple[dict[str, Any], ...] = (
    {"color": BLUE, "linestyle": "-"}, {"color": VERMILLION, "linestyle": (0, (4, 1.5))}
)  # fmt: skip
"""Of the longer slip length, and of the other."""


@styled
def figure_step_traces(
    traces: xr.Dataset, speed_mm_s: float, shown_ms: Mapping[str, tuple[float, float]] = SHOWN_MS
) -> Figure:
    """Return the force after a step on the median capable finger: a row for each law, steps by slip length.

    The oracle's force, where it competes, is in every panel: what plant and drive allow.
    """
    laws = traces["law"].values.tolist()
    columns = [(z, way) for z in traces["slip_length_um"].values.tolist() for way in STARTS_S]
    figure = new_figure(7.2, 0.8 * len(laws) + 1.0)
    grid = figure.subplots(len(laws), len(columns), squeeze=False, sharex="col", sharey=True)
    low, high = max(0.0, min(STEP_LEVELS_N) - ROOM_N), max(STEP_LEVELS_N) + ROOM_N
    for row, law in zip(grid, laws, strict=True):
        row[0].set_ylabel(law, fontweight="bold", rotation=0, ha="right", va="center")
        for axes, (z, way) in zip(row, columns, strict=True):
            since_ms, here = _since(traces.sel(slip_length_um=z), STARTS_S[way], shown_ms[way])
            if ORACLE in laws and law != ORACLE:
                axes.plot(since_ms, here["f_a"].sel(law=ORACLE), color=ORANGE, lw=1.6, label="oracle")
            force = here["f_a"].sel(law=law)
            axes.step(since_ms, here["f_r"].sel(law=law), where="post", color=GREY, lw=0.8, label="set-point")
            axes.plot(since_ms, force, color=BLUE, lw=0.9, label="this law")
            reached = [f"{end:.2g}" for end in (float(force.min()), float(force.max())) if not low <= end <= high]
            if reached:
                place = {"transform": axes.transAxes, "ha": "right", "va": "bottom", "fontsize": 7.0}
                axes.text(0.98, 0.04, f"cut off, reaches {' and '.join(reached)} N", **place)
    for axes, (z, way) in zip(grid[0], columns, strict=True):
        axes.set_title(f"slip length {z:g} um, step {way}")
        axes.set_xlim(*shown_ms[way])
    grid[0, 0].set(ylim=(low, high), yticks=STEP_LEVELS_N)
    figure.suptitle(f"force (N) at {speed_mm_s:g} mm/s", fontsize=9.0)
    for axes in grid[-1]:
        axes.set_xlabel("ms since the step")
    # The oracle's own panel has a line less.
    handles, labels = max((axes.get_legend_handles_labels() for axes in grid[:, 0]), key=lambda found: len(found[1]))
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def _since(traces: xr.Dataset, start_s: float, shown_ms: tuple[float, float]) -> tuple[np.ndarray, xr.Dataset]:
    """Return the time in ms since a step and what is shown of it."""
    first_ms, last_ms = shown_ms
    shown = traces.sel(time=slice(start_s + 1e-3 * first_ms, start_s + 1e-3 * last_ms))
    return 1e3 * (shown["time"].values - start_s), shown


@styled
def figure_sensitivities(
    frequency_hz: np.ndarray,
    found: Mapping[tuple[str, float], np.ndarray | None],
    laws: Sequence[str],
    speed_mm_s: float,
) -> Figure:
    """Return |S| over frequency on the median capable finger around 0.6 N, a panel for each law.

    ``found`` holds None for a loop that is unstable, which its panel says, and nothing for a law that has no linear
    loop: it has no panel.
    """
    drawn = [law for law in laws if any(law == name for name, _ in found)]
    rows = math.ceil(len(drawn) / COLUMNS)
    figure = new_figure(7.2, 1.7 * rows + 0.9)
    figure.suptitle(f"{speed_mm_s:g} mm/s", fontsize=9.0)
    grid = figure.subplots(rows, min(COLUMNS, len(drawn)), squeeze=False, sharex=True, sharey=True)
    for axes in grid.flat[len(drawn) :]:
        axes.remove()
    for axes in grid.flat[max(len(drawn) - COLUMNS, 0) : len(drawn)]:
        axes.set_xlabel("frequency (Hz)")
        axes.tick_params(labelbottom=True)
    lines = dict(zip(sorted({z for _, z in found}, reverse=True), LENGTH_LINES, strict=False))
    for axes, law in zip(grid.flat, drawn, strict=False):
        for other in (each for each in found.values() if each is not None):
            axes.loglog(frequency_hz, other, color=SILVER, lw=0.5)
        axes.axhline(1.0, color=GREY, lw=0.6)
        axes.set_title(law)
        _own(axes, frequency_hz, {z: size for (name, z), size in found.items() if name == law}, lines)
    for axes in grid[:, 0]:
        axes.set_ylabel("$|S|$, residual\nover disturbance")
    grid[0, 0].set_xlim(frequency_hz[0], frequency_hz[-1])
    kinds: list[Any] = [Line2D([], [], **line, label=f"slip length {z:g} um") for z, line in lines.items()]
    kinds.append(Line2D([], [], color=SILVER, lw=0.5, label="all laws"))
    figure.legend(handles=kinds, loc="outside lower center", ncols=len(kinds))
    return figure


def _own(
    axes: Axes,
    frequency_hz: np.ndarray,
    sizes: Mapping[float, np.ndarray | None],
    lines: Mapping[float, dict[str, Any]],
) -> None:
    """Draw |S| of one law by slip length, and name those at which it is unstable."""
    for z, size in sizes.items():
        if size is not None:
            axes.loglog(frequency_hz, size, lw=1.4, **lines[z])
    ringing = [f"{z:g} um" for z, size in sizes.items() if size is None]
    if ringing:
        said = "unstable" if len(ringing) == len(sizes) else f"unstable at {', '.join(ringing)}"
        axes.text(0.97, 0.06, said, transform=axes.transAxes, ha="right", fontweight="bold")
