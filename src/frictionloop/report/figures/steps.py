"""Fig. 5b and 5c: a set-point that steps, how fast the force follows, and what the amplitude does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from frictionloop.figures.style import BLACK, BLUE, GREEN, GREY, VERMILLION, new_figure, styled
from frictionloop.report.device import IDEAL, OPEN, PRINTED, RETUNED_GAINS
from frictionloop.report.step_response import PRINTED_MS, step_windows, times_ms

LOOKS = {OPEN: (GREY, "-."), PRINTED: (VERMILLION, ":"), RETUNED_GAINS: (BLUE, "-"), IDEAL: (GREEN, "--")}
SHOWN = (OPEN, PRINTED, RETUNED_GAINS)
SHOWN_S = (4.0, 6.1)
"""The piece of a stroke shown: two steps up and two down."""
CLOSE_MS = (-20.0, 120.0)
STROKE = 2
"""The stroke shown, the middle one."""


@styled
def figure_steps(stepped: Mapping[str, xr.Dataset], skin_ms: Mapping[str, float]) -> Figure:
    """Return a piece of a stroke for three controllers, and the times of all steps beside the printed ones."""
    figure = new_figure(9.2, 4.6)
    grid = figure.add_gridspec(3, 2, width_ratios=(1.5, 1))
    above: Axes | None = None
    for row, name in enumerate(SHOWN):
        axes = figure.add_subplot(grid[row, 0], sharex=above, sharey=above)
        above = above or axes
        _traces(axes, stepped[name].isel(stroke=STROKE), name)
        axes.tick_params(labelbottom=row == 2)
    axes.set_xlabel("time (s)")
    shown = [stepped[name].isel(stroke=STROKE).sel(time=slice(*SHOWN_S))["f_a"].max() for name in SHOWN]
    axes.set_ylim(0, max(1.05 * float(max(shown)), 1.0))
    _times(figure.add_subplot(grid[:, 1]), stepped, skin_ms)
    return figure


def _traces(axes: Axes, run: xr.Dataset, name: str) -> None:
    part = run.sel(time=slice(*SHOWN_S))
    color, _ = LOOKS[name]
    axes.plot(part["time"], part["f_a"], color=color, lw=0.9)
    axes.plot(part["time"], part["f_r"], "--", color=BLACK, lw=1.0)
    axes.set(xlim=SHOWN_S, ylabel="$f_a$ (N)")
    axes.set_title(f"{name} (dashes: set-point)", fontsize=8.5)


def _times(axes: Axes, stepped: Mapping[str, xr.Dataset], skin_ms: Mapping[str, float]) -> None:
    """Mark mean and standard deviation of the times of each controller, 63 % filled and 10 to 90 % hollow."""
    names, place = (OPEN, PRINTED, RETUNED_GAINS, IDEAL), 0.0
    labels: list[tuple[float, str]] = []
    for direction, (mean, sd) in PRINTED_MS.items():
        start = place - 0.6
        for name in names:
            times = times_ms(stepped[name], name, direction)
            for k, (shift, fill) in enumerate(((-0.17, LOOKS[name][0]), (0.17, "white"))):
                look: dict[str, Any] = {
                    "fmt": "os"[k],
                    "color": LOOKS[name][0],
                    "mfc": fill,
                    "ms": 5,
                    "capsize": 2.5,
                    "lw": 1.1,
                }
                axes.errorbar(times.mean[k], place + shift, xerr=times.sd[k], **look)
            labels.append((place, name.replace(", ", ",\n")))
            place += 1.0
        axes.fill_betweenx([start, place - 0.4], mean - sd, mean + sd, color="#e6e6e6", lw=0, zorder=0)
        axes.plot([mean] * 2, [start, place - 0.4], color=GREY, lw=1.2, zorder=0)
        if direction in skin_ms:
            axes.plot([skin_ms[direction]] * 2, [start, place - 0.4], ":", color=BLACK, lw=1.2)
        axes.text(96, start + 0.12, direction, ha="right", va="top", weight="bold", fontsize=8.5)
        place += 0.7
    axes.set(ylim=(place - 0.9, -0.8), xlim=(0, 98), xlabel="time of the response (ms)")
    axes.set_yticks([at for at, _ in labels], [name for _, name in labels])
    axes.grid(visible=False, axis="y")
    axes.plot([], [], "o", color=BLACK, label="to 63 %")
    axes.plot([], [], "s", color=BLACK, mfc="white", label="10 to 90 %")
    axes.fill_between([], [], color="#e6e6e6", label="paper, ± SD")
    axes.plot([], [], ":", color=BLACK, label="skin limit, 10 to 90 %")
    axes.legend(
        loc="upper center", bbox_to_anchor=(0.4, 1.14), ncols=4, fontsize=7, handlelength=1.3, columnspacing=0.9
    )


@styled
def figure_overshoot(stepped: Mapping[str, xr.Dataset], names: Sequence[str]) -> Figure:
    """Return the mean of force and amplitude over all steps of a direction, close up."""
    figure = new_figure(9.2, 4.2)
    panels = figure.subplots(2, 2, sharex=True, sharey="row")
    for column, direction in enumerate(PRINTED_MS):
        force, amplitude = panels[:, column]
        for name in names:
            color, dashes = LOOKS[name]
            windows = step_windows(stepped[name], direction).sel(since=slice(*CLOSE_MS))
            for axes, variable in ((force, "f_a"), (amplitude, "a")):
                mean, sd = windows[variable].mean("step"), windows[variable].std("step")
                if name == RETUNED_GAINS:
                    axes.fill_between(windows["since"], mean - sd, mean + sd, color=color, alpha=0.18, lw=0)
                axes.plot(windows["since"], mean, ls=dashes, color=color, lw=1.4, label=name)
        force.plot(windows["since"], windows["f_r"].mean("step"), color=BLACK, lw=0.9, label="set-point")
        force.set_title(f"{direction} step, mean of {windows.sizes['step']}")
        amplitude.set(xlabel="time since the step (ms)", xlim=CLOSE_MS)
    panels[0, 0].set_ylabel("friction force $f_a$ (N)")
    panels[1, 0].set_ylabel("amplitude $a$ (µm)")
    panels[1, 0].set_ylim(0, None)
    # At the left and narrow: on a phone the figure is scrolled, and begins with it.
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper left", ncols=2)
    return figure
