"""The figures of a certificate: of weights, hits, listed responses and quiet; and of a recording that is refused."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from frictionloop.figures.style import BLUE, GREY, SILVER, VERMILLION, new_figure, styled
from frictionloop.identification.file_channels import first_look
from frictionloop.report import bench_figures


@styled
def _line(curves: Mapping[str, Any]) -> Figure:
    figure = new_figure(6.2, 3.0)
    left, right = figure.subplots(1, 2)
    for force, reading, residual in zip(curves["force_n"], curves["reading"], curves["residual_n"], strict=True):
        left.plot(force, reading, "o", color=BLUE)
        right.plot(force, [1e3 * each for each in residual], "o", color=BLUE)
    ends = [min(map(min, curves["force_n"])), max(map(max, curves["force_n"]))]
    left.plot(ends, [curves["offset"] + curves["slope"] * each for each in ends], color=VERMILLION)
    right.axhline(0.0, color=VERMILLION)
    left.set(xlabel="force (N)", ylabel=f"reading ({curves['unit']})", title="Reading")
    right.set(xlabel="force (N)", ylabel="residual (mN)", title="What the line leaves")
    return figure


@styled
def _decay(curves: Mapping[str, Any]) -> Figure:
    figure = new_figure(6.2, 2.4)
    axes = figure.subplots()
    axes.plot([1e3 * each for each in curves["decay"]["time_s"]], curves["decay"]["reading"], color=BLUE, lw=0.8)
    axes.set(xlabel="time (ms)", ylabel="reading", title="The first good hit")
    return figure


@styled
def _poles(curves: Mapping[str, Any]) -> Figure:
    figure = new_figure(6.2, 2.6)
    axes = figure.subplots()
    for stable, colour, label in ((False, SILVER, "moves with the order"), (True, BLUE, "stays")):
        poles = [(hertz, order) for order, hertz, stays in curves["poles"] if stays is stable]
        axes.plot([p[0] for p in poles], [p[1] for p in poles], "o", ms=3, color=colour, label=label)
    for hertz in curves["modes_hz"]:
        axes.axvline(hertz, color=VERMILLION, lw=0.8)
    axes.set(xlabel="frequency (Hz)", ylabel="order", title="Poles over order; lines: the modes")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    if curves["modes_hz"]:
        axes.set_xlim(0, 1.5 * max(curves["modes_hz"]))
    axes.legend()
    return figure


@styled
def _response(curves: Mapping[str, Any]) -> Figure:
    data = curves["response"]
    if np.ptp(data["coherence"]) == 0:  # a listed response tells none
        figure = new_figure(6.2, 2.6)
        axes = figure.subplots()
        axes.loglog(data["frequency_hz"], data["magnitude"], ".", ms=4, color=BLUE, label="as listed")
        axes.set(xlabel="frequency (Hz)", ylabel="reading per force", title="Frequency response")
    else:
        figure = new_figure(6.2, 3.4)
        axes, below = figure.subplots(2, 1, sharex=True)
        axes.loglog(data["frequency_hz"], data["magnitude"], color=BLUE)
        axes.set(ylabel="reading per force", title="Frequency response")
        below.semilogx(data["frequency_hz"], data["coherence"], color=GREY)
        below.set(xlabel="frequency (Hz)", ylabel="coherence", ylim=(0, 1.05))
    if data.get("fitted"):
        axes.loglog(
            data.get("fitted_hz", data["frequency_hz"]), data["fitted"], color=VERMILLION, lw=0.8, label="fitted"
        )
        axes.legend()
    return figure


@styled
def _slides(curves: Mapping[str, Any]) -> Figure:
    figure = new_figure(6.2, 2.8)
    left, right = figure.subplots(1, 2)
    data = curves["slides"]
    left.plot(data["load_n"], data["friction_n"], "o", ms=4, color=BLUE)
    load = [0.0, max(data["load_n"])]
    left.plot(load, [data["mu"] * each for each in load], color=VERMILLION, lw=0.8, label=f"mu {data['mu']:.3g}")
    right.plot(data["start_s"], data["ratio"], "o", ms=4, color=BLUE)
    right.axhline(data["mu"], color=VERMILLION, lw=0.8)
    left.set(xlabel="load (N)", ylabel="friction (N)", title="Slides", xlim=(0, None), ylim=(0, None))
    right.set(xlabel="time of the slide (s)", ylabel="friction over load", title="One after the other")
    left.legend()
    return figure


@styled
def _density(curves: Mapping[str, Any]) -> Figure:
    figure = new_figure(6.2, 2.8)
    axes = figure.subplots()
    axes.loglog(curves["frequency_hz"], curves["density"], color=BLUE, lw=0.8)
    axes.plot(curves["band_hz"], [curves["level"]] * 2, color=VERMILLION, label="taken for the electronics")
    axes.set(xlabel="frequency (Hz)", ylabel="density (N/√Hz)", title="Noise")
    axes.legend()
    return figure


DRAWINGS: dict[str, dict[str, Callable[[Mapping[str, Any]], Figure]]] = {
    "weights": {"force_n": _line},
    "hits": {"decay": _decay, "poles": _poles, "response": _response},
    "response": {"response": _response, "poles": _poles},
    "quiet": {"density": _density},
    "load": {"force_n": _line},
    "slides": {"slides": _slides},
    "recording": {"file": lambda curves: first_look(curves["file"]).plot()},
    **bench_figures.DRAWINGS,
}
