"""Fig. 2a: fidelity over the gains, as maps and cuts, with their optimum and the useful range around it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, LogLocator

from frictionloop.figures.style import BLACK, BLUE, GREY, VERMILLION, new_figure, one_panel, styled
from frictionloop.loop.sweep import sweep
from frictionloop.parameters import System
from frictionloop.report.number_text import number
from frictionloop.report.tolerances import R2_STEP

KP, KI = "controller.kp", "controller.ki"
R20 = (1, 1.12, 1.25, 1.4, 1.6, 1.8, 2, 2.24, 2.5, 2.8, 3.15, 3.55, 4, 4.5, 5, 5.6, 6.3, 7.1, 8, 9)
"""Preferred numbers of a decade, twelve per cent apart (ISO 3)."""
KPS = np.array([0.63, 0.71, 0.8, 0.9, *R20, *np.multiply(R20, 10), 100])
"""Proportional gains, N/N."""
KIS = np.array([digits * decade for decade in (0.1, 1, 10, 100, 1e3, 1e4) for digits in R20[::2]] + [1e5])
"""Integral gains, 1/s; a map goes up to 10^4."""
SEEDS = 4
DURATION_S = 10.0


def fidelity_map(system: System, seeds: int = 2) -> xr.Dataset:
    """Return the median r2_identity over ``kp`` and ``ki``, and r2_bound."""
    found = sweep(
        system, {KP: KPS, KI: KIS[KIS <= 1e4]}, DURATION_S, seeds, ["r2_identity", "r2_bound"], progress=False
    ).median("seed")
    bound = found["r2_bound"].max()
    return xr.Dataset({"r2_identity": found["r2_identity"], "r2_bound": bound}).rename({KP: "kp", KI: "ki"})


def fidelity_over(system: System, path: str, values: np.ndarray = KPS) -> xr.Dataset:
    """Return r2_identity and saturation_index (medians over seeds) over one gain (dim ``gain``), and r2_bound."""
    names = ["r2_identity", "saturation_index", "r2_bound"]
    found = sweep(system, {path: values}, DURATION_S, SEEDS, names, progress=False).median("seed")
    return found.assign(r2_bound=found["r2_bound"].max()).rename({path: "gain"})


class Optimum(NamedTuple):
    """The best point of a cut or a map, and its fidelity."""

    kp: float
    ki: float
    r2: float


def optimum(fidelity: xr.DataArray, ki: float = 2.0) -> Optimum:
    """Return where fidelity over ``gain`` (then at this ``ki``) or over ``kp`` and ``ki`` is largest."""
    best = fidelity.isel(fidelity.argmax(...))
    if "gain" in best.coords:
        return Optimum(float(best["gain"]), ki, float(best))
    return Optimum(float(best["kp"]), float(best["ki"]), float(best))


class Range(NamedTuple):
    """A range of gains; an end is None where the sweep ends before the range does."""

    low: float | None
    high: float | None


def middle(found: Range) -> float | None:
    """Return the middle of a range by ratio; None where an end is missing.

    >>> middle(Range(5.0, 20.0)), middle(Range(5.0, None))
    (10.0, None)
    """
    return None if found.low is None or found.high is None else math.sqrt(found.low * found.high)


def useful_range(fidelity: xr.DataArray, step: float = R2_STEP) -> Range:
    """Return the gains around the best one with r2 within ``step`` of it, interpolated over the gain's logarithm."""
    gain, margin = np.log(fidelity["gain"].values), fidelity.values - float(fidelity.max()) + step
    best = int(np.argmax(margin))
    above = next((i for i in range(best, len(gain)) if margin[i] < 0), None)
    below = next((i for i in range(best, -1, -1) if margin[i] < 0), None)
    return Range(
        low=None if below is None else _zero(gain, margin, below, below + 1),
        high=None if above is None else _zero(gain, margin, above - 1, above),
    )


def _zero(x: np.ndarray, y: np.ndarray, i: int, j: int) -> float:
    """Return exp(x) where the line through points i and j crosses zero."""
    return math.exp(float(x[i] - y[i] * (x[j] - x[i]) / (y[j] - y[i])))


def at(fidelity: xr.DataArray, gain: float) -> float:
    """Return the fidelity at the gain of the sweep that is nearest to ``gain``."""
    return float(fidelity.sel(gain=gain, method="nearest"))


def spread(fidelity: xr.DataArray, low: float, high: float) -> float:
    """Return the largest minus the smallest fidelity for gains from ``low`` to ``high``."""
    within = fidelity.where((fidelity["gain"] >= low * (1 - 1e-9)) & (fidelity["gain"] <= high * (1 + 1e-9)), drop=True)
    return float(within.max() - within.min())


PAPER_POINT = (10.0, 2.0)
"""Kp and Ki that the paper chose (Sec. 2.3)."""
PAPER_RANGE = (5.0, 20.0)
"""Kp with "good disturbance rejection" (paper, Sec. 2.3)."""
BELOW_BEST = (0.5, 0.3, 0.2, 0.1, 0.05, 0.03, 0.02, R2_STEP, 0.005, 0.002)
"""Borders of a map's colours, as R2 below the best: finer where it matters."""

CASED = [withStroke(linewidth=3.0, foreground="white")]
"""A white casing: a black line is then seen on any colour of a map, and in its key on a dark page."""
EDGE_ROOM = 1.6
"""Room above the largest Ki, a factor, for a best point on the edge of the map."""


@styled
def figure_fidelity_map(fidelity: xr.Dataset, title: str) -> Figure:
    """Return R2 over Kp and Ki with the best point, the region within 1 % of it, and the paper's point."""
    figure, axes = one_panel(4.6, 3.9)
    r2 = fidelity["r2_identity"]
    best = optimum(r2)
    _colours(figure, axes, r2, best.r2)
    axes.plot([], [], color=BLACK, lw=1.3, path_effects=CASED, label=f"$R^2$ within {R2_STEP:g} of the best")
    words = f"{_best_on(r2, best)} {best.r2:.3f} at {number(best.kp)}, {number(best.ki)}"
    axes.plot(best.kp, best.ki, "*", color="white", mec=BLACK, ms=12, clip_on=False, zorder=5, label=words)
    kp, ki = PAPER_POINT
    axes.plot(kp, ki, "o", color=VERMILLION, mec="white", ms=7, label=f"{at_paper(r2):.3f} at the paper's 10, 2")
    axes.set(xscale="log", yscale="log", xlabel="proportional gain $K_p$", ylabel="integral gain $K_i$ (1/s)")
    _plain_ticks(axes)
    axes.set_ylim(float(r2["ki"][0]), float(r2["ki"][-1]) * EDGE_ROOM)
    axes.grid(False)
    axes.set_title(title)
    figure.legend(loc="outside lower center")
    return figure


def _best_on(r2: xr.DataArray, best: Optimum) -> str:
    """Return what the best point is: on the map's edge a better one may lie beyond."""
    edges = (float(r2["kp"][0]), float(r2["kp"][-1]), float(r2["ki"][0]), float(r2["ki"][-1]))
    at_edge = best.kp in edges[:2] or best.ki in edges[2:]
    return "largest of this map" + (", at its edge:" if at_edge else ":")


def _colours(figure: Figure, axes: Axes, r2: xr.DataArray, best: float) -> None:
    kp, ki, values = r2["kp"].values, r2["ki"].values, r2.values.T
    levels = [best - below for below in BELOW_BEST] + [best + 1e-9]
    filled = axes.contourf(kp, ki, values, levels, norm=BoundaryNorm(levels, 256, extend="min"), extend="min")
    # A hairline in each polygon's own colour hides the seams that viewers draw between polygons.
    filled.set(edgecolor="face", linewidth=0.2)
    axes.contour(kp, ki, values, [best - R2_STEP], colors=BLACK, linewidths=1.3).set(path_effects=CASED)
    figure.colorbar(
        filled, ax=axes, label="fidelity $R^2$ to $f_a = f_r$", format="%.3f", pad=0.02, ticks=levels, spacing="uniform"
    )


def at_paper(r2: xr.DataArray) -> float:
    """Return the fidelity of a map at the gains that the paper chose."""
    kp, ki = PAPER_POINT
    return float(r2.sel(kp=kp, ki=ki, method="nearest"))


def _plain_ticks(axes: Axes, vertical: bool = True) -> None:
    """Label gains as 1, 10, 100 instead of powers, the vertical axis as powers above 1000."""
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axes.xaxis.set_minor_formatter(FuncFormatter(lambda x, _: ""))
    if vertical:
        axes.yaxis.set_major_formatter(FuncFormatter(lambda x, _: number(x)))


@styled
def figure_fidelity_over_kp(cuts: Mapping[str, xr.Dataset]) -> Figure:
    """Return R2 over Kp at Ki = 2 for each system, a panel each, with its bound, its best gain and its useful range."""
    figure = new_figure(9.0, 4.6)
    panels = figure.subplots(2, 3).ravel()
    for axes, (name, cut) in zip(panels, cuts.items(), strict=False):
        _cut(axes, cut, name)
    _key(panels[-1])
    for axes in panels[2:5]:
        axes.set_xlabel("proportional gain $K_p$")
    for axes in panels[0::3]:
        axes.set_ylabel("fidelity $R^2$")
    return figure


def _cut(axes: Axes, cut: xr.Dataset, name: str) -> None:
    r2, bound = cut["r2_identity"], float(cut["r2_bound"])
    best, useful = optimum(r2), useful_range(r2)
    gain = r2["gain"].values
    axes.axvspan(*PAPER_RANGE, color="#e2e2e2", lw=0)
    axes.axhline(bound, color=GREY, ls=":", lw=1.2)
    axes.plot(gain, r2, color=BLUE)
    axes.plot([useful.low or gain[0], useful.high or gain[-1]], [best.r2 - R2_STEP] * 2, "|-", color=BLACK, lw=1, ms=6)
    axes.plot(best.kp, best.r2, "*", color=VERMILLION, mec="white", mew=0.5, ms=10)
    low = max(float(r2.min()), bound - BELOW_BEST[0])
    room = (bound - low) * 0.1
    axes.set(xscale="log", xlim=(0.6, 110), ylim=(low - room, bound + room))
    axes.set_title(f"{name}:\nbest {_where(useful)}", fontsize=8.5)
    _plain_ticks(axes, vertical=False)


def _where(useful: Range) -> str:
    """Return the range in words: no gain is the best of a curve that is flat to its end."""
    low = "" if useful.low is None else f"from $K_p$ = {number(useful.low)}"
    if useful.high is None:
        return f"{low} on" if low else "at any $K_p$"
    return f"{low} to {number(useful.high)}" if low else f"up to $K_p$ = {number(useful.high)}"


def _key(axes: Axes) -> None:
    axes.set_axis_off()
    axes.plot([], [], color=BLUE, label="fidelity at $K_i$ = 2")
    axes.plot([], [], color=GREY, ls=":", label="best within reach")
    axes.plot([], [], "*", color=VERMILLION, ms=10, ls="none", label="largest $R^2$ of this curve")
    axes.plot([], [], "|-", color=BLACK, lw=1, label=f"best: within {R2_STEP:g} of it")
    axes.fill_between([], [], color="#e2e2e2", label="printed range, 5 to 20")
    axes.legend(loc="center", fontsize=8.5)
