"""Figure: where the residual of each law comes from, by cause and by frequency."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from frictionloop.report.style import BLACK, BLUE, GREY, ORANGE, SKY, VERMILLION, new_figure, styled
from studies.causes import LIMITS

FILLS: tuple[dict[str, Any], ...] = (
    {"facecolor": BLUE, "hatch": ""},
    {"facecolor": ORANGE, "hatch": "////"},
    {"facecolor": SKY, "hatch": "...."},
    {"facecolor": VERMILLION, "hatch": "xxxx"},
)
"""Bars of the laws: told apart by hatching, too, and by brightness."""
WHOLE = {"all": "all", "silent": "no disturbance"}


@styled
def figure_why(found: xr.Dataset, speed_mm_s: float) -> Figure:
    """Return what each cause costs each law, and the residual in bands of frequency, a row of axes per contact.

    Bars are medians over fingers, thin lines reach to the worst decile; of bands there is none.
    """
    contacts, laws = found["contact"].values.tolist(), found["law"].values.tolist()
    causes = found["cause"].values.tolist()
    figure = new_figure(7.0, (0.5 + 0.17 * len(laws) * (len(causes) + 2)) * len(contacts) + 0.4)
    grid = figure.subplots(len(contacts), 2, squeeze=False, width_ratios=(3, 2), sharex="col")
    for (left, right), contact in zip(grid, contacts, strict=True):
        cell = found.sel(speed_mm_s=speed_mm_s, contact=contact)
        _by_cause(left, cell, laws, causes)
        _by_band(right, cell, laws)
        left.set_title(f"{contact}, {speed_mm_s:g} mm/s: by cause")
        right.set_title("by frequency")
    grid[-1, 0].set_xlabel("rms, and $\\sqrt{\\mathrm{all}^2 - \\mathrm{without}^2}$ of each cause, signed (mN)")
    grid[-1, 1].set_xlabel("rms of $f_a - f_r$ in a band (mN)")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    line = Line2D([], [], color=BLACK, lw=0.7, label="to the worst decile (numbers: medians)")
    figure.legend([*handles, line], [*labels, str(line.get_label())], loc="outside lower center", ncols=len(laws) + 1)
    return figure


def _by_cause(axes: Axes, cell: xr.Dataset, laws: Sequence[str], causes: Sequence[str]) -> None:
    for k, law in enumerate(laws):
        own = cell.sel(law=law)
        rows = [own[name].values for name in WHOLE] + [own["cost"].sel(cause=name).values for name in causes]
        middle, worst = (1e3 * np.array([_quantile(row, share) for row in rows]) for share in (0.5, 0.9))
        _bars(axes, k, len(laws), law, middle, worst)
    _name(axes, [*WHOLE.values(), *causes])
    axes.margins(x=0.28)
    own_limits = [name for name in causes if name in LIMITS]
    heads = {
        "rms": 0,
        "costs of disturbances": len(WHOLE),
        "costs of limits": len(WHOLE) + len(causes) - len(own_limits),
    }
    for head, first in heads.items():
        if first:
            axes.axhline(first - 0.5, color=GREY, lw=0.6)
        axes.annotate(
            head, (1.0, first - 0.42), xycoords=("axes fraction", "data"), ha="right", va="top", fontsize=7, color=GREY
        )


def _by_band(axes: Axes, cell: xr.Dataset, laws: Sequence[str]) -> None:
    edges = zip(cell["low_hz"].values.tolist(), cell["high_hz"].values.tolist(), strict=True)
    for k, law in enumerate(laws):
        values = 1e3 * cell["band_rms"].sel(law=law).values
        _bars(axes, k, len(laws), law, values, values)
    _name(axes, [f"{low:g}–{high:g} Hz" for low, high in edges])


def _bars(axes: Axes, k: int, of: int, law: str, middle: np.ndarray, worst: np.ndarray) -> None:
    """Draw medians as bars, thin lines from there to the worst decile, and say the median beyond both."""
    places, there = _places(middle.size, k, of), np.nan_to_num(middle)
    axes.barh(places, there, 0.8 / of, label=law, edgecolor=BLACK, lw=0.5, **FILLS[k % len(FILLS)])
    reach = np.maximum(there, np.nan_to_num(worst))
    axes.hlines(places, there, reach, color=BLACK, lw=0.7)
    ends = np.maximum(reach, 0.0)
    for place, value, end in zip(places, middle, ends, strict=True):
        # With a zero of its own, so that what rounds to it has no sign.
        said = "cannot be told" if np.isnan(value) else f"{round(value, 1) + 0.0:.1f}".replace("-", "−")
        axes.annotate(said, (end, place), (3, 0), textcoords="offset points", va="center", fontsize=6.5)


def _places(count: int, k: int, of: int) -> np.ndarray:
    return np.arange(count) + (k - (of - 1) / 2) * (0.8 / of)


def _name(axes: Axes, names: Sequence[str]) -> None:
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.axvline(0.0, color=GREY, lw=0.6)
    axes.margins(x=0.16, y=0.02)


def _quantile(values: np.ndarray, share: float) -> float:
    there = values[np.isfinite(values)]
    return float(np.quantile(there, share)) if there.size else float("nan")
