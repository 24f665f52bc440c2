"""The figure of one run: set-point and force, the vibration that made the force, and how the finger moved.

A recording of a device has no force on the finger, which nobody can measure there: its measured force is drawn.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionloop.analysis.operating_point import RECORDED
from frictionloop.figures.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION, new_figure, styled
from frictionloop.loop.companion_runs import disturbance_left, open_loop_of
from frictionloop.loop.metrics import rms_error
from frictionloop.loop.record import system_of
from frictionloop.parameters import Recording
from frictionloop.parameters.presets import stirring
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

SHADE, SET = "#ececec", "#8a8a8a"
MOVING = (
    ("position", "position\n(mm)", 1e3, GREEN),
    ("speed", "speed\n(mm/s)", 1e3, ORANGE),
    ("load", "load\n(N)", 1.0, PURPLE),
)
"""Traces of a finger that moves: name, label, factor, colour."""
STEADY = 0.9
"""Share of the rms error below which what varies of it is told apart from its mean (chosen)."""
NEAR_0 = 0.6
"""Lowest force over the highest below which the axis begins at 0 (chosen)."""
BINS = 3000
"""Stretches of time that a trace is drawn in, each by its lowest and highest value: more than a page has dots."""


@styled
def figure_of(run: xr.Dataset) -> Figure:
    """Return f_r and the force over time, in open loop too, the disturbance, the amplitude and the finger's motion."""
    disturbed = "d" in run and bool(np.ptp(run["d"].values) > 0)
    traces = [("d", "disturbance\n$d$ (N)", 1.0, PURPLE)] if disturbed else []
    # The plate's amplitude, or a device's command.
    amplitude = run["a"].attrs["long_name"].partition(",")[0].replace(" ", "\n")
    traces += [("a", f"{amplitude} (µm)", 1.0, GREY), *(each for each in MOVING if each[0] in run)]
    figure = new_figure(8.0, 3.5 + 1.0 * len(traces))
    force, *rest = figure.subplots(1 + len(traces), sharex=True, height_ratios=(3, *(1 for _ in traces)))
    time = run["time"].values
    _forces(force, run, time)
    for axes, (name, label, factor, colour) in zip(rest, traces, strict=True):
        axes.plot(*_ends(time, factor * run[name].values), color=colour, linewidth=1.0)
        axes.set(ylabel=label)
        if name == "a":
            axes.set_ylim(0, None)
        else:
            axes.margins(y=0.15)
    if disturbed:
        rest[0].set_title(_recorded(run), loc="right", fontsize=7.5, fontweight="normal", pad=3.0)
    if "scored" in run:
        _shade(figure.axes, time, ~run["scored"].values)
    figure.axes[-1].set(xlabel="time (s)", xlim=(0, time[-1] + (time[1] if time.size > 1 else 1.0)))
    figure.legend(*force.get_legend_handles_labels(), loc="outside upper center", ncols=2)
    figure.align_ylabels()
    return figure


def _recorded(run: xr.Dataset) -> str:
    """Return of which file, column and part the disturbance is; empty of one that was not recorded."""
    signal = system_of(run).disturbance
    if not isinstance(signal, Recording):
        return ""
    begins = "" if signal.start_s is None else f", t = 0 is {signal.start_s:g} s in it"
    return f"{Path(signal.path).name}, column {signal.column}{begins}"


def _forces(axes: Any, run: xr.Dataset, time: np.ndarray) -> None:
    """Draw the forces, the set-point thin and dark above them; one that varies as they do wide and grey below."""
    drawn, meaning = ("f_a", "force on the finger $f_a$") if "f_a" in run else ("f_m", "measured force $f_m$")
    if "limit" in run:
        top, bottom = (_ends(time, run[name].values + run["d"].values) for name in ("limit", "floor"))
        label = "within reach of the plate"
        axes.fill_between(top[0], bottom[1], top[1], color="#e8f1f8", linewidth=0, label=label, zorder=0.5)
    opened = _opened(run)
    if opened is not None:
        own = ",\nthe finger's own drift included" if stirring(system_of(run)) else ""
        label = f"the same in open loop{_error(opened)}{own}"
        axes.plot(*_ends(time, opened[drawn].values), color=VERMILLION, linewidth=0.7, label=label)
    label = f"{meaning}{_error(run)}{_left(run) if opened is not None else ''}"
    axes.plot(*_ends(time, run[drawn].values), color=BLUE, linewidth=0.9, label=label)
    measured = system_of(run).setpoint.kind in RECORDED
    look = {"color": SET, "linewidth": 2.2, "zorder": 1.8} if measured else {"color": BLACK, "linewidth": 0.8}
    axes.plot(*_ends(time, run["f_r"].values), label="set-point $f_r$", **look)
    forces = run[drawn].values if opened is None else np.stack([run[drawn].values, opened[drawn].values])
    low, high = _room(run, forces)
    axes.set(ylabel="force (N)", ylim=(low, high))
    least, most = float(np.nanmin(forces)), float(np.nanmax(forces))
    if low is not None and high is not None and (least < low or most > high):
        # In the legend, where it covers nothing.
        beyond = {"marker": r"$\updownarrow$", "linestyle": "", "color": GREY, "markersize": 9}
        axes.plot([], [], label=f"not scored: {least:.2g} to {most:.2g} N", **beyond)


def _opened(run: xr.Dataset) -> xr.Dataset | None:
    """Return the run with the loop open; None for one that is open, and where that is not known."""
    try:
        opened = open_loop_of(run)
    except FrictionloopError:
        return None
    if opened is None or np.array_equal(opened["f_a"].values, run["f_a"].values):
        return None
    return opened.assign(scored=run["scored"]) if "scored" in run else opened  # the error of the same periods


def _error(run: xr.Dataset) -> str:
    """Return the error for the legend, nothing where no period counts or no force on the finger is known."""
    try:
        error_mn = 1e3 * rms_error(run)
    except (FrictionloopError, KeyError):
        return ""
    scored = run["scored"].values if "scored" in run else slice(None)
    varies_mn = 1e3 * float(np.std((run["f_a"].values - run["f_r"].values)[scored]))
    # A steady error is not what a person looks for who compares two curves that vary.
    own = f", {varies_mn:.3g} without its mean" if varies_mn < STEADY * error_mn else ""
    return f": error {error_mn:.3g} mN rms{own}"


def _left(run: xr.Dataset) -> str:
    """Return for the legend how much of a disturbance's variation is left, as the metric of that name has it."""
    try:
        left = disturbance_left(run, run["scored"].values if "scored" in run else None)
    except FrictionloopError:
        return ""
    return "" if np.isnan(left) else f";\n{100 * left:.0f} % of $d$ left, rms"


def _ends(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a trace as its lowest and highest values in short stretches, in turn, so that a long run draws quickly."""
    if time.size <= 4 * BINS:
        return time, values
    length = -(-time.size // BINS)
    starts = np.arange(0, time.size, length)
    low, high = np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)
    return np.repeat(time[starts], 2), np.stack([low, high], axis=1).ravel()


def _room(run: xr.Dataset, forces: np.ndarray) -> tuple[float, float] | tuple[None, None]:
    """Return limits for the forces that count, shape (..., time); those of a reversal and the reach may leave."""
    if "scored" not in run or not run["scored"].values.any():
        return None, None
    scored = run["scored"].values
    counted = np.concatenate([run["f_r"].values[scored], forces[..., scored].ravel()])
    low, high = float(counted.min()), float(counted.max())
    low = min(0.0, low) if low < NEAR_0 * high else low  # a small variation about a level is drawn about that level
    room = 0.08 * (high - low)
    return low - room * (low != 0), high + room


def _shade(panels: Any, time: np.ndarray, left_out: np.ndarray) -> None:
    """Shade what metrics leave out."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], left_out, [False]]).astype(int)))
    stops = np.append(time, time[-1])
    for k, (start, stop) in enumerate(edges.reshape(-1, 2)):
        for axes in panels:
            label = "not scored" if k == 0 and axes is panels[0] else None
            axes.axvspan(time[start], stops[stop], color=SHADE, linewidth=0, zorder=0.7, label=label)
