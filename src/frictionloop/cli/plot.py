"""The figure of one run: set-point and force, and the vibration that made the force."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from frictionloop.quantities import replacing
from frictionloop.report.style import BLUE, GREY, new_figure, styled, svg

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

SILVER = "#b3b3b3"


@styled
def figure_of(run: xr.Dataset) -> Figure:
    """Return f_r and f_a over time, above the vibration amplitude a."""
    figure = new_figure(8.0, 4.5)
    force, amplitude = figure.subplots(2, sharex=True, height_ratios=(3, 1))
    time = run["time"].values
    # A wide light line under a thin dark one stays readable where a fast sweep fills the page; dashes do not.
    force.plot(time, run["f_r"].values, color=SILVER, linewidth=2.6, label="set-point $f_r$")
    force.plot(time, run["f_a"].values, color=BLUE, linewidth=1.0, label="force on the finger $f_a$")
    force.set(ylabel="force (N)")
    amplitude.plot(time, run["a"].values, color=GREY, linewidth=1.0)
    amplitude.set(ylabel="vibration\namplitude (µm)", xlabel="time (s)", xlim=(0, time[-1] + time[1]), ylim=(0, None))
    figure.legend(*force.get_legend_handles_labels(), loc="outside upper right", ncols=2)
    figure.align_ylabels()
    return figure


def draw(run: xr.Dataset, path: str | os.PathLike[str]) -> None:
    """Draw a run into a file; the name's ending chooses svg, pdf or png."""
    figure, ending = figure_of(run), Path(path).suffix.lstrip(".")
    with replacing(path) as beside:
        if ending == "svg":
            beside.write_text(svg(figure, "run"), encoding="utf-8")
        else:
            figure.savefig(beside, format=ending, dpi=200)
