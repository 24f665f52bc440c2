"""Fig. 5b and 5c: steps taken apart, response times, the skin's limit, and what the amplitude does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from frictionloop.figures.style import BLACK, BLUE, GREEN, GREY, ORANGE, VERMILLION, new_figure, styled
from frictionloop.loop.record import system_of
from frictionloop.loop.transients import StepTime, step_times
from frictionloop.parameters import Friction, Skin, Strokes, System
from frictionloop.physics.friction import amplitude_for
from frictionloop.report.other_fingers import the_finger
from frictionloop.report.paper_protocol import IDEAL, OPEN, PRINTED, RETUNED_GAINS, SLOW, STEP_LEVELS_N, finger_system

BEFORE_MS, AFTER_MS = 100.0, 400.0
"""A window around a step; the level after it lasts 500 ms."""
SETTLED_MS = 200.0
"""From here on a level counts as settled: the 37 ms of the paper and five standard deviations of it have passed."""
SHARE_10_90 = 0.8
PRINTED_MS = {"falling": (37.0, 20.0), "rising": (32.0, 16.0)}
"""Mean and standard deviation of the response (paper, Sec. 4.2)."""
DIRECTIONS = tuple(PRINTED_MS)


class Times(NamedTuple):
    """Mean and standard deviation (ms) of the times to 63 % and from 10 to 90 %, and how many steps gave them."""

    mean: tuple[float, float]
    sd: tuple[float, float]
    steps: int

    @property
    def to_63(self) -> float | None:
        """Mean time to 63 %, None where no step was followed."""
        return self.mean[0] if self.steps else None

    @property
    def from_10_to_90(self) -> float | None:
        """Mean time from 10 to 90 %, likewise."""
        return self.mean[1] if self.steps else None


def responses(runs: xr.Dataset, own_levels: bool = False) -> list[StepTime]:
    """Return the step times of all strokes, counted from the set-point's levels or from those the force settled at."""
    found: list[StepTime] = []
    for j in range(runs.sizes["stroke"]):
        run = runs.isel(stroke=j)
        found += step_times(run.assign(f_r=("time", _own_levels(run))) if own_levels else run)
    return found


def _own_levels(run: xr.Dataset) -> np.ndarray:
    """Return, for each period, the mean force over the settled part of its level."""
    rate_hz = 1.0 / float(run["time"][1] - run["time"][0])
    settled = round(1e-3 * SETTLED_MS * rate_hz)
    parts = np.split(run["f_a"].values, np.flatnonzero(np.diff(run["f_r"].values)) + 1)
    return np.concatenate([np.full(part.size, part[settled:].mean()) for part in parts])


def times_ms(runs: xr.Dataset, controller: str, direction: str) -> Times:
    """Return the response times of a controller, NaN where no step was followed.

    Without control, and where it rings, the force does not come to the set-point's levels; there they are its own.
    """
    up = direction == "rising"
    found = [each for each in responses(runs, controller in (OPEN, PRINTED)) if (each.to_n > each.from_n) == up]
    if not found:
        return Times((np.nan, np.nan), (np.nan, np.nan), 0)
    table = 1e3 * np.array([[each.to_63_s, each.rise_s] for each in found])
    (a, b), (c, d) = table.mean(axis=0).tolist(), table.std(axis=0).tolist()
    return Times((a, b), (c, d), len(found))


def step_windows(runs: xr.Dataset, direction: str) -> xr.Dataset:
    """Return f_r, f_a, a and saturated around every step of a direction, over ``step`` and ``since`` (ms)."""
    rate_hz = 1.0 / float(runs["time"][1] - runs["time"][0])
    before, after = (round(1e-3 * ms * rate_hz) for ms in (BEFORE_MS, AFTER_MS))
    since = np.arange(-before, after) / rate_hz * 1e3
    windows = []
    for j in range(runs.sizes["stroke"]):
        run = runs.isel(stroke=j)
        jumps = np.diff(run["f_r"].values)
        for k in np.flatnonzero(jumps > 0 if direction == "rising" else jumps < 0) + 1:
            if before <= k <= run.sizes["time"] - after:
                windows.append(run.isel(time=slice(k - before, k + after)).drop_vars("time"))
    return xr.concat(windows, "step").rename(time="since").assign_coords(since=since)


def commanded_um(runs: xr.Dataset) -> xr.DataArray:
    """Return the amplitude that the lookup table makes of the force command, um, before the plate's low-pass."""
    model = system_of(runs).controller.model
    table = Friction(nominal_n=model.nominal_n, susceptibility_per_um2=model.susceptibility_per_um2)
    return runs["u"].copy(data=amplitude_for(runs["u"].values, table))


def overshoot(runs: xr.Dataset, direction: str) -> float:
    """Return how far the commanded amplitude goes beyond where it settles after a step, over the step that it makes.

    Of the mean over all steps, so that what differs from step to step does not count.
    """
    amplitude = step_windows(runs.assign(a=commanded_um(runs)), direction)["a"].mean("step")
    start = float(amplitude.sel(since=slice(-BEFORE_MS, -1)).mean())
    end = float(amplitude.sel(since=slice(SETTLED_MS, None)).mean())
    way = (amplitude.sel(since=slice(0, SETTLED_MS)) - start) / (end - start)
    return float(way.max()) - 1.0


def mean_peak_n(runs: xr.Dataset) -> float:
    """Return the largest force after a rising step, in N, of the mean over all of them."""
    return float(step_windows(runs, "rising")["f_a"].mean("step").sel(since=slice(0, SETTLED_MS)).max())


def steady_error_n(runs: xr.Dataset) -> np.ndarray:
    """Return f_a - f_r where a level has settled, in N."""
    errors = []
    for direction in DIRECTIONS:
        settled = step_windows(runs, direction).sel(since=slice(SETTLED_MS, None))
        errors.append((settled["f_a"] - settled["f_r"]).values.ravel())
    return np.concatenate(errors)


def skin_limit_ms(system: System, step_n: float) -> float:
    """Return the least time from 10 to 90 % of a rise at a steady speed, 0.8 dF/(k v) in ms.

    The tip lags no faster than the finger moves, so the skin pulls at most k v harder.
    """
    finger, motion = system.finger, system.motion
    assert isinstance(finger, Skin) and isinstance(motion, Strokes)
    return 1e3 * SHARE_10_90 * step_n / (finger.stiffness_n_m * 1e-3 * motion.speed_mm_s)


def this_skin_limit_ms() -> float:
    """Return the least time from 10 to 90 % of the steps up, for the chosen finger."""
    return skin_limit_ms(finger_system(the_finger()), STEP_LEVELS_N[1] - STEP_LEVELS_N[0])


LOOKS: dict[str, tuple[str, Any]] = {
    OPEN: (GREY, "-."),
    PRINTED: (VERMILLION, ":"),
    RETUNED_GAINS: (BLUE, "-"),
    SLOW: (ORANGE, (0, (5, 1, 1, 1))),
    IDEAL: (GREEN, "--"),
}
SHOWN = (OPEN, PRINTED, RETUNED_GAINS, SLOW)
SHOWN_S = (4.0, 6.1)
"""The piece of a stroke shown: two steps up and two down."""
CLOSE_MS = (-20.0, 120.0)
STROKE = 2
"""The stroke shown, the middle one."""


@styled
def figure_steps(stepped: Mapping[str, xr.Dataset], skin_ms: Mapping[str, float]) -> Figure:
    """Return a piece of a stroke for some controllers, and the times of all steps beside the printed ones."""
    figure = new_figure(9.2, 5.4)
    grid = figure.add_gridspec(len(SHOWN), 2, width_ratios=(1.5, 1))
    above: Axes | None = None
    for row, name in enumerate(SHOWN):
        axes = figure.add_subplot(grid[row, 0], sharex=above, sharey=above)
        above = above or axes
        _traces(axes, stepped[name].isel(stroke=STROKE), name)
        axes.tick_params(labelbottom=name == SHOWN[-1])
    axes.set_xlabel("time (s)")
    shown = [stepped[name].isel(stroke=STROKE).sel(time=slice(*SHOWN_S))["f_a"].max() for name in SHOWN]
    axes.set_ylim(0, max(1.05 * float(max(shown)), 1.0))
    _times(figure.add_subplot(grid[:, 1]), stepped, skin_ms)
    return figure


def _traces(axes: Axes, run: xr.Dataset, name: str) -> None:
    part = run.sel(time=slice(*SHOWN_S))
    axes.plot(part["time"], part["f_a"], color=LOOKS[name][0], lw=0.9)
    axes.plot(part["time"], part["f_r"], "--", color=BLACK, lw=1.0)
    axes.set(xlim=SHOWN_S, ylabel="$f_a$ (N)")
    axes.set_title(f"{name} (dashes: set-point)", fontsize=8.5)


def _times(axes: Axes, stepped: Mapping[str, xr.Dataset], skin_ms: Mapping[str, float]) -> None:
    """Mark mean and standard deviation of the times of each controller, 63 % filled and 10 to 90 % hollow."""
    place = 0.0
    labels: list[tuple[float, str]] = []
    for direction, (mean, sd) in PRINTED_MS.items():
        start = place - 0.6
        for name, (color, _) in LOOKS.items():
            times = times_ms(stepped[name], name, direction)
            for k, (shift, fill) in enumerate(((-0.17, color), (0.17, "white"))):
                look: dict[str, Any] = {"fmt": "os"[k], "color": color, "mfc": fill, "ms": 5, "capsize": 2.5, "lw": 1.1}
                axes.errorbar(times.mean[k], place + shift, xerr=times.sd[k], **look)
            labels.append((place, name.replace(", ", ",\n")))
            place += 1.0
        axes.fill_betweenx([start, place - 0.4], mean - sd, mean + sd, color="#e6e6e6", lw=0, zorder=0)
        axes.plot([mean] * 2, [start, place - 0.4], color=GREY, lw=1.2, zorder=0)
        if direction in skin_ms:
            axes.plot([skin_ms[direction]] * 2, [start, place - 0.4], ":", color=BLACK, lw=1.2)
        axes.text(96, start + 0.12, direction, ha="right", va="top", weight="bold", fontsize=8.5)
        place += 0.7
    axes.set(ylim=(place - 0.9, -0.8), xlim=(0, 98), xlabel="time of the response (ms)")
    axes.set_yticks([at for at, _ in labels], [name for _, name in labels])
    axes.grid(visible=False, axis="y")
    axes.plot([], [], "o", color=BLACK, label="to 63 %")
    axes.plot([], [], "s", color=BLACK, mfc="white", label="10 to 90 %")
    axes.fill_between([], [], color="#e6e6e6", label="paper, ± SD")
    axes.plot([], [], ":", color=BLACK, label="skin limit, 10–90 %")
    axes.legend(loc="upper center", bbox_to_anchor=(0.4, 1.1), ncols=4, fontsize=7, handlelength=1.3, columnspacing=0.9)


@styled
def figure_overshoot(stepped: Mapping[str, xr.Dataset], names: Sequence[str]) -> Figure:
    """Return the mean of force and commanded amplitude over all steps of a direction, close up."""
    figure = new_figure(9.2, 4.2)
    panels = figure.subplots(2, 2, sharex=True, sharey="row")
    for column, direction in enumerate(PRINTED_MS):
        force, amplitude = panels[:, column]
        for name in names:
            color, dashes = LOOKS[name]
            runs = stepped[name].assign(a=commanded_um(stepped[name]))
            windows = step_windows(runs, direction).sel(since=slice(*CLOSE_MS))
            for axes, variable in ((force, "f_a"), (amplitude, "a")):
                mean, sd = windows[variable].mean("step"), windows[variable].std("step")
                if name == RETUNED_GAINS:
                    axes.fill_between(windows["since"], mean - sd, mean + sd, color=color, alpha=0.18, lw=0)
                axes.plot(windows["since"], mean, ls=dashes, color=color, lw=1.4, label=name)
        force.plot(windows["since"], windows["f_r"].mean("step"), color=BLACK, lw=0.9, label="set-point")
        force.set_title(f"{direction} step, mean of {windows.sizes['step']}")
        amplitude.set(xlabel="time since the step (ms)", xlim=CLOSE_MS)
    panels[0, 0].set_ylabel("friction force $f_a$ (N)")
    panels[1, 0].set_ylabel("command (µm)")
    panels[1, 0].set_ylim(0, None)
    # At the left and narrow: on a phone the figure is scrolled, and begins with it.
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper left", ncols=2)
    return figure
