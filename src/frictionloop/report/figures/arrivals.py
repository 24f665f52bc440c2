"""How much of each effect arrives, and how differently fingers are given it: the figure of a stored study."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator, PercentFormatter

from frictionloop.figures.style import BLACK, BLUE, GREY, ORANGE, new_figure, styled
from frictionloop.report.arrivals import LAWS, Arrivals

LOOKS: dict[str, dict[str, Any]] = {
    "lookup": {"color": GREY, "ls": (0, (1, 1)), "marker": "o"},
    "retuned_pi": {"color": ORANGE, "ls": (0, (5, 1.5)), "marker": "s"},
    "notch_pi": {"color": BLUE, "ls": "-", "marker": "D"},
}
"""Line of each law, told apart in grey too."""
COLUMNS = 4


@styled
def figure_arrivals(found: Arrivals) -> Figure:
    """Return the spread between fingers over the speed, above a panel for each effect with its contrast."""
    effects = found.effects
    lines = -(-len(effects) // COLUMNS)
    figure = new_figure(7.2, 3.1 + 1.5 * lines)
    parts: Any = figure.subfigures(2, 1, height_ratios=(2.7, 1.5 * lines + 0.4))
    above, below = parts
    panel = above.subplots()
    _draw_spread(panel, found)
    # At the left and narrow: on a phone the figure is scrolled, and begins with it.
    above.legend(*panel.get_legend_handles_labels(), loc="outside lower left", ncols=2)
    grid = below.subplots(lines, COLUMNS, sharex=True, sharey=True, squeeze=False)
    for number, (axes, effect) in enumerate(zip(grid.ravel(), effects, strict=False)):
        axes.axhline(1.0, color=BLACK, lw=0.7)
        for law in found.laws:
            axes.plot(found.speeds_mm_s, found.values(law, "contrast")[number], ms=3.0, lw=1.2, **LOOKS[law])
        axes.set_title(effect, pad=3.0)
    for axes in grid.ravel()[len(effects) :]:
        axes.set_axis_off()
    _over_speed(grid[0, 0], found)
    grid[0, 0].set_ylim(0.0, 2.0)
    grid[0, 0].yaxis.set_major_formatter(PercentFormatter(1.0))
    below.supxlabel("speed (mm/s)", fontsize=8.5)
    below.supylabel("contrast that arrives", fontsize=8.5)
    return figure


def _draw_spread(axes: Axes, found: Arrivals) -> None:
    for law in found.laws:
        spread = 1e3 * found.values(law, "spread_n")
        look = LOOKS[law]
        axes.fill_between(found.speeds_mm_s, spread.min(0), spread.max(0), color=look["color"], alpha=0.15, lw=0)
        axes.plot(found.speeds_mm_s, np.median(spread, axis=0), label=LAWS[law], **look)
    _over_speed(axes, found)
    axes.set(yscale="log", ylim=(2.0, 300.0), ylabel="between fingers (mN)", xlabel="speed (mm/s)")
    axes.set_yticks([3, 10, 30, 100, 300], ["3", "10", "30", "100", "300"])
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_title("How differently fingers are given one effect")


def _over_speed(axes: Axes, found: Arrivals) -> None:
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(FixedLocator(list(found.speeds_mm_s)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xticklabels([f"{speed:g}" for speed in found.speeds_mm_s])
