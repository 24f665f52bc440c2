"""How much of effects arrives under three laws on many fingers, as a stored study has found it.

The report runs none of it: ``python -m studies.arrivals`` does, and writes the file in ``report/stored``.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator, PercentFormatter

from frictionloop.figures.style import BLACK, BLUE, GREY, ORANGE, new_figure, styled
from frictionloop.quantities import Array

COMMAND = "python -m studies.arrivals"
FILE = "arrivals.json"
LAWS = {
    "lookup": "open loop",
    "retuned_pi": "re-tuned PI",
    "notch_pi": "notch and feed-forward",
}
"""Laws that are told of, by the name of the entrant."""
EFFECTS = (
    *("gradient", "edge", "bump", "hole", "detents", "slider"),
    *("grating", "square", "triangle", "chirp", "rough", "braille"),
)
"""Effects of the library that vary over place; the others are levels, or need a press or a speed."""
SPEEDS_MM_S = (20.0, 50.0, 100.0, 150.0)


@dataclass(frozen=True)
class Arrivals:
    """What the study has found of the fingers that are capable."""

    version: str
    seed: int
    fingers: int
    speeds_mm_s: tuple[float, ...]
    laws: Mapping[str, Mapping[str, Mapping[str, Sequence[float]]]]
    """Numbers over the speeds, by law, effect and what is told."""

    command = COMMAND

    @property
    def effects(self) -> list[str]:
        """Names of the effects."""
        return list(next(iter(self.laws.values())))

    @property
    def told_of(self) -> str:
        """How many fingers are told of, least and most over the speeds."""
        counts = self.values(next(iter(self.laws)), "fingers")
        low, high = counts.min(), counts.max()
        return f"{low:g}" if low == high else f"{low:g} to {high:g}"

    @property
    def speeds(self) -> str:
        """The speeds in words."""
        *first, last = (f"{speed:g}" for speed in self.speeds_mm_s)
        return f"{', '.join(first)} and {last}"

    def values(self, law: str, told: str) -> Array:
        """Return what `design.comparison.effect_comparison.arrived` tells under a name, shape (effects, speeds)."""
        return np.array([effect[told] for effect in self.laws[law].values()])

    def middle(self, law: str, told: str) -> float:
        """Return the median over effects and speeds."""
        return float(np.median(self.values(law, told)))

    def at(self, law: str, told: str, speed_mm_s: float) -> float:
        """Return the median over effects at one of the speeds."""
        return float(np.median(self.values(law, told)[:, self.speeds_mm_s.index(speed_mm_s)]))

    @property
    def sentence(self) -> str:
        """The first number of the study in one sentence."""
        here, there = (1e3 * self.middle(law, "spread_n") for law in ("lookup", "notch_pi"))
        return (
            f"Between fingers forces differ by {here:.0f} mN open loop, by {there:.0f} mN with a notch and feed-forward"
        )


@cache
def stored() -> Arrivals:
    """Return the study that comes with the package."""
    found = json.loads((files("frictionloop.report") / "stored" / FILE).read_text(encoding="utf-8"))
    about = {name: found[name] for name in ("version", "seed", "fingers", "laws")}
    return Arrivals(**about, speeds_mm_s=tuple(found["speeds_mm_s"]))


def rows(found: Arrivals) -> Iterator[tuple[str, ...]]:
    """Yield heads, then what is told of all effects, the spread between fingers first, then a row for each effect."""
    yield ("", *(LAWS[law] for law in found.laws))
    for words, told, factor in _SUMMARY:
        yield (words, *(f"{factor * found.middle(law, told):.0f}" for law in found.laws))
    for number, name in enumerate(found.effects):
        contrasts = (found.values(law, "contrast")[number] for law in found.laws)
        yield (name, *(" ".join(f"{100 * each:.0f}" for each in some) for some in contrasts))


_SUMMARY: Any = (
    ("between fingers (mN)", "spread_n", 1e3),
    ("error (mN rms)", "rms_error_n", 1e3),
    ("error as felt (thresholds)", "error_felt", 1.0),
    ("pattern as felt (thresholds)", "pattern_felt", 1.0),
)
"""Medians over effects and speeds."""


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
    axes.set_title("How differently effects arrive")


def _over_speed(axes: Axes, found: Arrivals) -> None:
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(FixedLocator(list(found.speeds_mm_s)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xticklabels([f"{speed:g}" for speed in found.speeds_mm_s])
