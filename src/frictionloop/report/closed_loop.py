"""Fig. 5a: its numbers, force against set-point over five strokes at three levels, and the same for a population."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from frictionloop.analysis.linear import check_pi
from frictionloop.figures.style import BLACK, BLUE, GREEN, GREY, ORANGE, VERMILLION, new_figure, one_panel, styled
from frictionloop.parameters import System
from frictionloop.report import paper_protocol
from frictionloop.report.claims.claim import Value
from frictionloop.report.gain_stability import Stability, stability
from frictionloop.report.number_text import number
from frictionloop.report.other_fingers import the_finger
from frictionloop.report.paper_protocol import AMPLITUDE_N, CONTROLLERS, IDEAL, OPEN, PRINTED, RETUNED_GAINS, fit
from frictionloop.report.results import Results
from frictionloop.report.system_comparison import GROUND

Row = dict[str, Value]
Table = dict[str, Row]


def strokes(names: Iterable[str], results: Results) -> Table:
    """Return gains, where they are stable, R2, slope, spread about the regression and error, by controller."""
    base = paper_protocol.finger_system(the_finger())
    return {name: _gains(name, base.evolve(CONTROLLERS[name])) | fit(results.tracked[name])._asdict() for name in names}


def _gains(name: str, system: System) -> Row:
    if name == OPEN:
        return {"kp": None, "ki": None, **dict.fromkeys(Stability._fields)}
    controller = check_pi(system)
    return {"kp": controller.kp, "ki": controller.ki, **stability(system)._asdict()}


DOTS = 100
"""Points of one stroke."""
GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
LEVEL_LOOKS = ((BLUE, "o"), (ORANGE, "s"), (GREEN, "^"))
LIMITS_N = (0.25, 0.95)
"""Ends of the axis of set-points."""
ABOVE = 1.7
"""Axis over the forces that the scores stand above."""
LEAST_TOP_N = 1.3
"""Upper end of the axis of forces where no force is as large: the scores stand above the forces then."""
COMPARED = (OPEN, PRINTED, RETUNED_GAINS, IDEAL)
"""Controllers whose forces have one axis."""


@styled
def figure_closed_loop(tracked: Mapping[str, xr.Dataset], names: Sequence[str], rows: Table) -> Figure:
    """Return force against set-point for some controllers, a panel each, with the regression and both kinds of R2.

    Each panel says the gains, and how stable their loop is, from ``rows`` by controller (`strokes`).
    The axis of forces is that of all controllers, so that figures can stand side by side.
    """
    figure = new_figure(2.3 * len(names), 3.5)
    panels = figure.subplots(1, len(names), sharex=True, sharey=True)
    top_n = max(LEAST_TOP_N, *(_top_n(tracked[name]) for name in tracked if name in COMPARED))
    for axes, name in zip(panels, names, strict=True):
        row = rows[name]
        _cloud(axes, tracked[name], top_n, _stable(row))
        kp, ki = row["kp"], row["ki"]
        gains = "" if kp is None or ki is None else f"\n$K_p$ {number(kp, 4)}, $K_i$ {number(ki, 4)} 1/s"
        axes.set_title(("open loop, the table" if name == OPEN else name) + gains, fontsize=8.5)
        axes.set_xlabel("set-point $f_r$ (N)")
    panels[0].set_ylabel("friction force $f_a$ (N)")
    handles, words = panels[0].get_legend_handles_labels()
    figure.legend(handles, words, loc="outside lower center", ncols=3, markerscale=2.5)
    return figure


def _top_n(runs: xr.Dataset) -> float:
    """Return an upper end of the axis that holds the forces, those of the lower levels below the scores."""
    forces, left = runs["f_a"], runs["f_a"].isel(level=slice(0, -1))
    return max(1.05 * float(forces.quantile(0.999)), ABOVE * float(left.quantile(0.99)))


def _cloud(axes: Axes, runs: xr.Dataset, top_n: float, stable: str) -> None:
    # Multiples of the golden ratio: spread evenly over the stroke and over the period of the set-point.
    some = np.sort((np.arange(DOTS) * GOLDEN % 1.0 * runs.sizes["time"]).astype(int))
    for (color, marker), level_n in zip(LEVEL_LOOKS, runs["level"].values, strict=False):
        part = runs.sel(level=level_n).isel(time=some)
        look: dict[str, Any] = {"ms": 1.6, "mew": 0, "alpha": 0.55, "color": color}
        words = f"{level_n:g} ± {AMPLITUDE_N:g} N"
        axes.plot(part["f_r"].values.ravel(), part["f_a"].values.ravel(), marker, ls="none", **look, label=words)
    found = fit(runs)
    r = runs["f_r"].values.ravel()
    offset = float(runs["f_a"].mean()) - found.slope * r.mean()
    ends = np.array([r.min(), r.max()])
    axes.plot(LIMITS_N, LIMITS_N, "--", color=GREY, lw=1.2, label="$f_a = f_r$")
    axes.plot(ends, offset + found.slope * ends, color=BLACK, lw=1.6, label="regression")
    r2 = found.r2_identity
    identity = f"{r2:.3f}".replace("-", "−") if r2 > -1 else number(r2)
    scores = [
        f"regression $R^2$ {found.r2_regression:.3f}",
        f"to $f_a = f_r$: {identity}",
        f"error {number(1e3 * found.error_n)} mN rms",
        *([stable] if stable else []),
    ]
    look = {"va": "top", "linespacing": 1.4, "fontsize": 8, "bbox": GROUND}
    axes.text(0.04, 0.97, "\n".join(scores), transform=axes.transAxes, **look)
    axes.set(xlim=LIMITS_N, ylim=(0, top_n))


def _stable(row: Mapping[str, Value]) -> str:
    """Return Ms at the forces asked for, or where the loop is unstable; empty for the open loop."""
    peak, moist, from_n = row["sensitivity_peak"], row["sensitivity_peak_moist"], row["stable_from_n"]
    if peak is None:
        return ""
    if math.isfinite(peak):
        if moist is None or math.isnan(moist):
            return f"$M_s$ {number(peak)}"
        after = "\nunstable when moist" if math.isinf(moist) else f", when moist {number(moist)}"
        return f"$M_s$ {number(peak)}{after}"
    return "unstable" if from_n is None else f"unstable below {number(from_n)} N"


@styled
def figure_people(people: Mapping[str, xr.Dataset]) -> Figure:
    """Return the rms error of each finger of a population under each controller, capable ones filled."""
    figure, axes = one_panel(4.8, 4.0)
    order = np.argsort(people[RETUNED_GAINS]["error_n"].values)
    able = people[RETUNED_GAINS]["capable"].values[order]
    looks = {OPEN: ("D", GREY), PRINTED: ("s", VERMILLION), RETUNED_GAINS: ("o", BLUE)}
    place = np.arange(1, order.size + 1)
    for name, (marker, color) in looks.items():
        error_mn = 1e3 * people[name]["error_n"].values[order]
        axes.plot(place[able], error_mn[able], marker, color=color, ms=5, label=name)
        axes.plot(place[~able], error_mn[~able], marker, color=color, mfc="white", ms=5)
    axes.axhline(20, color=BLACK, ls=":", lw=1.1)
    axes.text(order.size + 0.6, 19, "20 mN", fontsize=7.5, ha="right", va="top")
    axes.plot([], [], "o", color=BLACK, mfc="white", label="hollow: not from\n0.3 to 0.9 N")
    axes.set(yscale="log", xlim=(0.2, order.size + 0.8), xlabel="finger, by its re-tuned error")
    axes.set_xticks([1, *range(5, order.size + 1, 5)])
    axes.set_ylabel("error $f_a - f_r$ (mN rms)")
    axes.set_yticks([10, 20, 50, 100, 200, 500, 1000], ["10", "20", "50", "100", "200", "500", "1000"])
    axes.minorticks_off()
    axes.set_ylim(3.5, None)
    axes.legend(loc="lower right", ncols=2, fontsize=7.5)
    return figure
