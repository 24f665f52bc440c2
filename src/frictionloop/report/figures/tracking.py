"""Fig. 1a, friction against amplitude over trials; Fig. 2b to 2d, force against set-point and a piece of both."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from frictionloop.figures.style import BLACK, BLUE, GREY, VERMILLION, new_figure, one_panel, styled
from frictionloop.loop.metrics import r2_identity, saturation_index
from frictionloop.parameters import FrictionLimit
from frictionloop.physics.friction import friction_force
from frictionloop.report.numbers import number

BINS_UM = np.linspace(0.0, 2.5, 11)
EVERY = 4
"""Of the samples of a trial, one in four is drawn."""


def binned(trials: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return bin centres in um, mean and standard deviation of the force in N over all trials."""
    within = np.clip(np.digitize(trials["a"].values, BINS_UM) - 1, 0, len(BINS_UM) - 2)
    forces = [trials["f"].values[:, within == k].ravel() for k in range(len(BINS_UM) - 1)]
    centres = (BINS_UM[1:] + BINS_UM[:-1]) / 2
    return centres, np.array([f.mean() for f in forces]), np.array([f.std() for f in forces])


@styled
def figure_population(trials: xr.Dataset, nominal: FrictionLimit) -> Figure:
    """Return the forces of all trials in grey, their mean and standard deviation in black, equation (1) in blue."""
    figure, axes = one_panel()
    lines = axes.plot(trials["a"].values[::EVERY], trials["f"].values[:, ::EVERY].T, color=GREY, alpha=0.4, lw=0.5)
    lines[0].set_label("one trial")
    centres, mean, spread = binned(trials)
    axes.errorbar(centres, mean, spread, fmt="o-", color=BLACK, capsize=3, lw=1.2, label="mean ± SD of the trials")
    curve = np.linspace(0, 2.5, 200)
    axes.plot(curve, friction_force(curve, nominal), "--", color=BLUE, label="eq. (1) with $d = 0$, as printed")
    axes.set(xlabel="vibration amplitude $a$ (µm)", ylabel="friction force $f$ (N)", xlim=(-0.03, 2.53), ylim=(0, None))
    axes.set_title(f"{trials.sizes['trial']} synthetic sliding trials")
    axes.legend(loc="upper right")
    return figure


DOTS = 1500
"""Points of an input-output cloud, evenly spaced in time."""
PIECE_S = (2.2, 2.6)
"""The piece shown over time: the sweep passes 3 Hz."""

GROUND = {"fc": "white", "ec": "none", "alpha": 0.8, "pad": 1.5}
"""White ground of words that lie over data."""


@styled
def figure_tracking(run: xr.Dataset, kp: float, limits_n: tuple[float, float]) -> Figure:
    """Return the input-output cloud of a run above a piece of its traces, forces within ``limits_n``."""
    figure = new_figure(3.2, 4.9)
    above, below = figure.subplots(2, height_ratios=(1.55, 1))
    _cloud(above, run, limits_n)
    above.set_title(f"$K_p$ = {number(kp)}")
    scores = f"$R^2$ = {r2_identity(run):.3f}\nsaturated {saturation_index(run):.0%}"
    above.text(0.04, 0.97, scores, transform=above.transAxes, va="top", linespacing=1.4, bbox=GROUND)
    _traces(below, run.sel(time=slice(*PIECE_S)), limits_n)
    below.plot([], [], "--", color=BLACK, lw=1, label="$f_a = f_r$")
    figure.legend(*below.get_legend_handles_labels(), loc="outside lower center", ncols=2, handlelength=2.2)
    return figure


def _cloud(axes: Axes, run: xr.Dataset, limits_n: tuple[float, float]) -> None:
    shown = run.isel(time=np.linspace(0, run.sizes["time"] - 1, DOTS).astype(int))
    axes.plot(shown["f_r"], shown["f_a"], "o", ms=1.5, color=BLUE, alpha=0.5, mew=0)
    axes.plot(limits_n, limits_n, "--", color=BLACK, lw=1)
    axes.set(xlim=limits_n, ylim=limits_n, aspect="equal")
    axes.set(xlabel="set-point $f_r$ (N)", ylabel="friction force $f_a$ (N)")


def _traces(axes: Axes, run: xr.Dataset, limits_n: tuple[float, float]) -> None:
    time = run["time"]
    axes.plot(time, run["d"], ":", color=GREY, lw=1.2, label="disturbance $d$")
    axes.plot(time, run["f_a"], color=BLUE, lw=0.8, label="friction $f_a$")
    axes.plot(time, run["f_r"], "--", color=VERMILLION, lw=1.4, label="set-point $f_r$")
    axes.set(xlim=PIECE_S, ylim=(min(limits_n[0], float(run["d"].min())), limits_n[1]))
    axes.set(xlabel="time (s)", ylabel="force (N)")


def common_limits_n(runs: list[xr.Dataset]) -> tuple[float, float]:
    """Return limits that hold f_r and f_a of several runs, with a twentieth of room, in N."""
    values = [float(getattr(run[name], end)()) for run in runs for name in ("f_r", "f_a") for end in ("min", "max")]
    room = (max(values) - min(values)) / 20
    return min(values) - room, max(values) + room
