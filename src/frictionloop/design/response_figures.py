"""Figures of a designed controller: sensitivity over resonances against its limits, and a step before and after."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from frictionloop.analysis.limits import Headroom
from frictionloop.analysis.linear import condition_of
from frictionloop.analysis.operating_point import force_band
from frictionloop.design.grid_corners import Corner, at_mean
from frictionloop.figures.style import BLACK, BLUE, GREEN, GREY, ORANGE, VERMILLION, new_figure, styled
from frictionloop.loop.simulate import simulate
from frictionloop.parameters import Constant, Steps, System
from frictionloop.perception.detection_thresholds import HIGHEST_HZ

UP_S, DOWN_S, END_S = 0.5, 1.0, 1.5
"""Times of the step, s."""
AROUND = 0.1
"""Share of a set-point that stays where it is, by which it is stepped up and down (chosen)."""
ROUND = 0.6
"""Share of the upper level that is at least drawn below and above the step (chosen)."""
LOWEST_HZ, FROM_HZ = 1.0, 10.0
"""Where frequencies begin: all of them, and those at which |S| has its peaks."""
FLOOR, ROOM = 1e-3, 1.15
"""Least |T| drawn, and how far the axis of the peaks goes above the largest Ms asked for."""
STEPPED = ("before: as in the file", "after: as designed")
"""Names of the two runs of a step."""
LINES = ((BLACK, "-"), (BLUE, (0, (4, 1.5))), (VERMILLION, (0, (1, 1))))
"""Colour and dashes for no, the small and the large error of the resonance."""


def stepped(system: System) -> tuple[tuple[float, float], str]:
    """Return the levels between which the set-point of a system is stepped, N, and where they come from in words."""
    low, mean, high = force_band(system.evolve({"disturbance": Constant(offset_n=0.0)}))
    if low < high:
        return (low, high), "ends of the set-point"
    return ((1.0 - AROUND) * mean, (1.0 + AROUND) * mean), f"{AROUND:.0%} around a set-point that stays at {mean:.3g} N"


def step_run(system: System) -> xr.Dataset:
    """Return a run of a step between the levels of the set-point and back, under its own disturbance."""
    low, high = stepped(system)[0]
    setpoint = Steps(times_s=(0.0, UP_S, DOWN_S), levels_n=(low, high, low))
    return simulate(system.evolve({"setpoint": setpoint}), END_S)


@styled
def figure_sensitivity(
    system: System, found: Headroom, limits: Mapping[float, float], worst: Corner | None = None
) -> Figure:
    """Return |S| and |T| with the resonance as described and off, the least |S| possible, and the delay's limit.

    A corner with the largest Ms, at another force, finger or speed, is drawn beside. |S| is drawn twice: over all
    decades, and its peaks, on a linear scale, against the largest Ms asked for.
    """
    figure = new_figure(7.2, 6.0)
    figure.suptitle(f"{found.loop.elements.force_n:.3g} N, just landed, {condition_of(system)}", fontsize=9.0)
    panels = figure.subplot_mosaic([["S", "S"], ["peak", "T"]])
    frequency = np.geomspace(LOWEST_HZ, found.loop.nyquist_hz, 1500)
    for (error, limit), (colour, dashes) in zip(sorted(limits.items()), LINES, strict=False):
        for sign in (-1.0, 1.0) if error else (1.0,):
            responses = at_mean(system, sign * error).responses(frequency)
            style = {"color": colour, "linestyle": dashes, "lw": 1.4 if not error else 1.0}
            said = f"resonance ±{100 * error:.3g} %" if error else "this loop"
            panels["S"].loglog(frequency, np.abs(responses["S"]), label=said if sign > 0 else None, **style)
            panels["peak"].semilogx(frequency, np.abs(responses["S"]), **style)
            panels["T"].loglog(frequency, np.maximum(np.abs(responses["T"]), FLOOR), **style)
        asked = f"asked ±{100 * error:.3g} %: {limit:.3g}" if error else f"asked: {limit:.3g}"
        panels["peak"].axhline(limit, color=colour, linestyle=dashes, lw=0.7)
        panels["peak"].annotate(asked, (FROM_HZ, limit), (3, 2), textcoords="offset points", fontsize=7.0)
    if worst is not None:
        responses = worst.loop.responses(frequency)
        style = {"color": GREY, "linestyle": (0, (5, 1, 1, 1)), "lw": 1.2}
        panels["S"].loglog(frequency, np.abs(responses["S"]), label=f"worst: {worst.condition}", **style)
        panels["peak"].semilogx(frequency, np.abs(responses["S"]), **style)
        panels["T"].loglog(frequency, np.maximum(np.abs(responses["T"]), FLOOR), **style)
    lowest = np.abs(found.sensitivity)[found.frequency_hz >= LOWEST_HZ].min()
    if np.isfinite(found.least).any():
        # Beyond what touch feels hardly anything is to be lowered, and the least residual leaves |S| open there.
        felt = (found.frequency_hz >= LOWEST_HZ) & (found.frequency_hz <= HIGHEST_HZ)
        panels["S"].loglog(found.frequency_hz[felt], found.least[felt], color=GREEN, lw=2.4, label="Bode's least")
        lowest = min(lowest, found.least[felt].min())
    for axes in panels.values():
        axes.axhline(1.0, color=GREY, lw=0.6)
        axes.axvline(found.delay_limit_hz, color=ORANGE, lw=1.0, ls=(0, (8, 2)), label="delay limit")
        axes.set(xlabel="frequency (Hz)", xlim=(LOWEST_HZ, found.loop.nyquist_hz))
    panels["S"].set(title="$|S|$, left of a disturbance", ylim=(max(FLOOR, 0.5 * float(lowest)), 6.0))
    panels["peak"].set(
        title="peaks of $|S|$", xlim=(FROM_HZ, found.loop.nyquist_hz), ylim=(0.0, ROOM * max(limits.values()))
    )
    panels["T"].set(title="$|T|$, of noise and set-point error", ylim=(FLOOR, 6.0))
    handles, labels = panels["S"].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3 if worst is None else 2)
    return figure


@styled
def figure_step(before: xr.Dataset, after: xr.Dataset, levels: str) -> Figure:
    """Return the force over the steps, under the controller that the file had and, below, under the new one.

    ``levels`` says where those of the step come from. Either run may ring or miss by several set-points: the axis shows
    what is around the levels, and a panel says how far its force goes beyond it.
    """
    figure = new_figure(7.0, 4.2)
    some, from_n, to_n = slice(UP_S - 0.1, None), float(after["f_r"].min()), float(after["f_r"].max())
    way = max(to_n - from_n, ROUND * to_n)
    low, high = max(0.0, from_n - way), to_n + way
    panels = figure.subplots(2, sharex=True, sharey=True)
    for axes, run, name, colour in zip(panels, (before, after), STEPPED, (VERMILLION, BLUE), strict=True):
        part = run.sel(time=some)
        axes.plot(part["time"], part["f_a"], color=colour, lw=0.9)
        axes.step(part["time"], part["f_r"], where="post", color=BLACK, lw=1.2, ls=(0, (4, 1.5)), label="set-point")
        beyond = float(part["f_a"].max()) > high or float(part["f_a"].min()) < low
        ends = f"{float(part['f_a'].min()):.2g} to {float(part['f_a'].max()):.2g} N"
        axes.set(title=f"{name}: cut off, the force goes from {ends}" if beyond else name, ylabel="friction force (N)")
    panels[0].set_ylim(low, high)
    panels[1].set(xlabel="time (s)", xlim=(UP_S - 0.1, END_S))
    figure.suptitle(f"Step {from_n:.3g} to {to_n:.3g} N and back: {levels}", fontsize=9.0)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center")
    return figure
