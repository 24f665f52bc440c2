"""Figures of a designed controller: sensitivity over resonances against its limits, and a step before and after."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from frictionloop.design.corners import at_mean, stroke_of
from frictionloop.design.headroom import Headroom
from frictionloop.loop.simulate import simulate
from frictionloop.parameters import Steps, System
from frictionloop.perception.thresholds import HIGHEST_HZ
from frictionloop.report.style import BLACK, BLUE, GREEN, GREY, ORANGE, VERMILLION, new_figure, styled

LOW_N, HIGH_N, UP_S, DOWN_S, END_S = 0.35, 0.75, 0.5, 1.0, 1.5
"""The step: levels as in the comparison of laws, times in s."""
FLOOR = 1e-3
LINES = ((BLACK, "-"), (BLUE, (0, (4, 1.5))), (VERMILLION, (0, (1, 1))))
"""Colour and dashes for no, the small and the large error of the resonance."""


def drawings(before: System, after: System, found: Headroom, limits: Mapping[float, float]) -> Mapping[str, Any]:
    """Return how to draw each figure, by name."""
    return {
        "sensitivity": partial(figure_sensitivity, after, found, limits),
        "step": partial(figure_step, step_run(before), step_run(after)),
    }


def step_run(system: System) -> xr.Dataset:
    """Return a run of the step 0.35 to 0.75 N and back, without a disturbance of its own."""
    setpoint = Steps(times_s=(0.0, UP_S, DOWN_S), levels_n=(LOW_N, HIGH_N, LOW_N))
    return simulate(system.evolve({"setpoint": setpoint}), END_S)


@styled
def figure_sensitivity(system: System, found: Headroom, limits: Mapping[float, float]) -> Figure:
    """Return |S| and |T| with the resonance as described and off, the least |S| possible, and the delay's limit."""
    figure = new_figure(7.4, 3.9)
    figure.suptitle(f"{found.loop.elements.force_n:.3g} N, dry finger{stroke_of(system)}", fontsize=9.0)
    left, right = figure.subplots(1, 2, sharex=True)
    frequency = np.geomspace(1.0, found.loop.nyquist_hz, 1500)
    for (error, limit), (colour, dashes) in zip(sorted(limits.items()), LINES, strict=False):
        for sign in (-1.0, 1.0) if error else (1.0,):
            loop = at_mean(system, sign * error)
            responses = loop.responses(frequency)
            size = {"color": colour, "linestyle": dashes, "lw": 1.4 if not error else 1.0}
            said = f"resonance ±{100 * error:.3g} %" if error else "this loop"
            label = said if sign > 0 else None
            left.loglog(frequency, np.abs(responses["S"]), label=label, **size)
            right.loglog(frequency, np.maximum(np.abs(responses["T"]), FLOOR), **size)
        left.plot([0.72, 1.0], [limit] * 2, transform=left.get_yaxis_transform(), color=colour, lw=0.7)
    if np.isfinite(found.least).any():
        # Beyond what touch feels hardly anything is to be lowered, and the least residual leaves |S| open there.
        felt = found.frequency_hz <= HIGHEST_HZ
        left.loglog(found.frequency_hz[felt], found.least[felt], color=GREEN, lw=1.4, label="least possible")
    left.text(
        0.71, max(limits.values()), "largest $M_s$", transform=left.get_yaxis_transform(), ha="right", va="center"
    )
    for axes in (left, right):
        axes.axhline(1.0, color=GREY, lw=0.6)
        axes.axvline(found.delay_limit_hz, color=ORANGE, lw=1.0, label="0 dB that the delay allows")
    _finish(left, "$|S|$: what is left of a disturbance", found.loop.nyquist_hz)
    _finish(right, "$|T|$: what noise and set-point error become", found.loop.nyquist_hz)
    left.set_ylim(max(FLOOR, 0.5 * float(np.min(found.sensitivity))), 6.0)
    right.set_ylim(FLOOR, 6.0)
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


@styled
def figure_step(before: xr.Dataset, after: xr.Dataset) -> Figure:
    """Return the force over the steps, under the controller that the file had and under the new one."""
    figure = new_figure(7.0, 3.4)
    axes = figure.subplots()
    some = slice(UP_S - 0.1, None)
    for run, label, colour, width in ((before, "before", VERMILLION, 0.8), (after, "after", BLUE, 1.2)):
        part = run.sel(time=some)
        axes.plot(part["time"], part["f_a"], label=label, color=colour, lw=width)
    part = after.sel(time=some)
    axes.plot(part["time"], part["f_r"], label="set-point", color=GREY, lw=0.9)
    axes.set(title=f"Step {LOW_N:g} to {HIGH_N:g} N and back", xlabel="time (s)", ylabel="friction force (N)")
    axes.set_ylim(0.0, None)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _finish(axes: Axes, title: str, nyquist_hz: float) -> None:
    axes.set(title=title, xlabel="frequency (Hz)", xlim=(1.0, nyquist_hz))
