"""A step down and a step up under each control law, close enough to tell them apart."""

from __future__ import annotations

from collections.abc import Sequence

import xarray as xr
from matplotlib.figure import Figure

from frictionloop.report.figures.tournament import legend_below, line_of
from frictionloop.report.style import GREY, new_figure, styled

WINDOWS_S = {"step down": (0.99, 1.06), "step up": (1.49, 1.60)}
"""Around the second and the third step of the protocol."""


@styled
def figure_close_steps(traces: xr.Dataset, laws: Sequence[str], left_out: Sequence[str] = ()) -> Figure:
    """Return force over time around two steps, per contact; ``laws`` decide the colours, also of those left out."""
    contacts = traces["contact"].values.tolist()
    figure = new_figure(6.8, 2.1 * len(contacts) + 0.7)
    grid = figure.subplots(len(contacts), len(WINDOWS_S), squeeze=False, sharex="col", sharey=True)
    for row, contact in zip(grid, contacts, strict=True):
        for axes, (name, (start_s, stop_s)) in zip(row, WINDOWS_S.items(), strict=True):
            some = traces.sel(contact=contact, time=slice(start_s, stop_s))
            time_ms = 1e3 * (some["time"] - start_s - 0.01)
            axes.step(time_ms, some["f_r"].isel(law=0), where="post", color=GREY, lw=0.8, label="set-point")
            for law in (each for each in laws if each not in left_out):
                axes.plot(time_ms, some["f_a"].sel(law=law), lw=1.0, label=law, **line_of(laws, law))
            axes.set_title(f"{contact}, {name}")
    for axes in grid[-1]:
        axes.set_xlabel("time after the step (ms)")
    for axes in grid[:, 0]:
        axes.set_ylabel("friction force (N)")
    legend_below(figure, grid[0, 0])
    return figure
