"""A step down and a step up under a few control laws, close enough to tell them apart."""

from __future__ import annotations

from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from frictionloop.report.style import GREEN, GREY, ORANGE, PURPLE, SKY, new_figure, styled

LINES: tuple[dict[str, Any], ...] = (
    {"color": GREEN, "linestyle": (0, (1, 1))},
    {"color": ORANGE, "linestyle": (0, (6, 1.5, 1, 1.5))},
    {"color": PURPLE, "linestyle": "-"},
    {"color": SKY, "linestyle": (0, (4, 1.5))},
)
"""Lines of the laws: dashes tell them apart, too, so that colour is never alone."""
WINDOWS_S = {"step down": (0.99, 1.06), "step up": (1.49, 1.60)}
"""Around the second and the third step of the protocol."""


@styled
def figure_close_steps(traces: xr.Dataset) -> Figure:
    """Return force over time around two steps under four laws, per contact."""
    contacts = traces["contact"].values.tolist()
    figure = new_figure(6.8, 2.1 * len(contacts) + 0.7)
    grid = figure.subplots(len(contacts), len(WINDOWS_S), squeeze=False, sharex="col", sharey=True)
    for row, contact in zip(grid, contacts, strict=True):
        for axes, (name, (start_s, stop_s)) in zip(row, WINDOWS_S.items(), strict=True):
            some = traces.sel(contact=contact, time=slice(start_s, stop_s))
            time_ms = 1e3 * (some["time"] - start_s - 0.01)
            axes.step(time_ms, some["f_r"], where="post", color=GREY, lw=0.8, label="set-point")
            for law, line in zip(some["law"].values.tolist(), LINES, strict=True):
                axes.plot(time_ms, some["f_a"].sel(law=law), lw=1.0, label=law, **line)
            axes.set_title(f"{contact}, {name}")
    for axes in grid[-1]:
        axes.set_xlabel("time after the step (ms)")
    for axes in grid[:, 0]:
        axes.set_ylabel("friction force (N)")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure
