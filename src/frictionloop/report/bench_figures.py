"""Drawings of a certificate for what is measured beyond the force sensor."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from matplotlib.figure import Figure

from frictionloop.figures.style import BLUE, GREY, SILVER, VERMILLION, new_figure, styled
from frictionloop.identification.people import People


def _over(curves: Mapping[str, Any], title: str, x: str, y: str, dots: bool, scale: float = 1.0) -> Figure:
    """Return what was measured and what was fitted over one axis."""
    figure = new_figure(6.2, 2.6)
    axes = figure.subplots()
    place = [scale * each for each in curves["x"]]
    axes.plot(place, curves["y"], "o" if dots else "-", ms=3, lw=0.8, color=BLUE, label="measured")
    if "fitted" in curves:
        axes.plot(place, curves["fitted"], color=VERMILLION, lw=1.0, label="fitted")
        axes.legend()
    axes.set(xlabel=x, ylabel=y, title=title)
    return figure


@styled
def sweep(curves: Mapping[str, Any]) -> Figure:
    """Draw a stepped sine."""
    data = curves["sweep"]
    return _over(data, "Stepped sine", "frequency (kHz)", f"vibration ({data['unit']})", True, 1e-3)


@styled
def decay(curves: Mapping[str, Any]) -> Figure:
    """Draw a rise or fall of the vibration: its periods are too many to be seen, its envelope is not."""
    data = curves["decay"]
    figure = new_figure(6.2, 2.6)
    axes = figure.subplots()
    time = [1e3 * each for each in data["x"]]
    left = [a - b for a, b in zip(data["y"], data["fitted"], strict=True)]
    axes.plot(time, data["y"], color=BLUE, lw=0.4, label="measured")
    axes.plot(time, left, color=VERMILLION, lw=0.6, label="what the fit leaves")
    axes.set(xlabel="time (ms)", ylabel=f"vibration ({data['unit']})", title="After the drive was switched")
    axes.legend()
    return figure


@styled
def envelope(curves: Mapping[str, Any]) -> Figure:
    """Draw a rise or fall of the envelope."""
    data = curves["envelope"]
    return _over(data, "After the drive was switched", "time (ms)", f"amplitude ({data['unit']})", False, 1e3)


@styled
def pairs(curves: Mapping[str, Any]) -> Figure:
    """Draw a scale and what its line leaves."""
    data = curves["pairs"]
    figure = new_figure(6.2, 2.8)
    left, right = figure.subplots(1, 2)
    left.plot(data["x"], data["y"], "o", ms=3, color=BLUE)
    left.plot(data["x"], data["fitted"], color=VERMILLION, lw=0.8)
    right.plot(data["x"], [y - f for y, f in zip(data["y"], data["fitted"], strict=True)], "o", ms=3, color=BLUE)
    right.axhline(0.0, color=VERMILLION, lw=0.8)
    left.set(xlabel=data["labels"][0], ylabel=data["labels"][1], title="Scale")
    right.set(xlabel=data["labels"][0], ylabel=f"residual, {data['labels'][1]}", title="What the line leaves")
    return figure


@styled
def drift(curves: Mapping[str, Any]) -> Figure:
    """Draw how a resonance moves."""
    data = curves["drift"]
    label = f"resonance − {data['middle']:.0f} Hz (Hz)"
    return _over(data, "Drift of the resonance", "time (min)", label, len(data["x"]) < 60)


@styled
def answer(curves: Mapping[str, Any]) -> Figure:
    """Draw the answer to the first jump."""
    return _over(curves["answer"], "Answer to the first jump", "time (ms)", "answer", False, 1e3)


@styled
def law(curves: Mapping[str, Any]) -> Figure:
    """Draw what is left of friction over the amplitude, and the laws."""
    data = curves["law"]
    figure = new_figure(6.2, 3.0)
    axes = figure.subplots()
    axes.plot(data["amplitude_um"], data["share"], "o", ms=2, color=SILVER, label="0.1 s of a slide")
    for (name, curve), colour, style in zip(
        data["laws"].items(), (VERMILLION, BLUE, GREY), ("-", "--", ":"), strict=True
    ):
        axes.plot(data["fine_um"], curve, style, color=colour, label=name)
    axes.set(
        xlabel="amplitude (µm)", ylabel="share of friction left", title="Laws, the likeliest first", ylim=(0, None)
    )
    axes.legend()
    return figure


@styled
def crowd(found: People) -> Figure:
    """Draw each finger as measured and as pooled, by its first two values."""
    figure = new_figure(6.2, 3.0)
    axes = figure.subplots()
    second = min(1, found.raw.shape[1] - 1)
    for k, name in enumerate(found.names):
        ends = [[math.exp(each[k, column]) for each in (found.raw, found.pooled)] for column in (0, second)]
        axes.plot(*ends, color=SILVER, lw=0.8)
        axes.plot(ends[0][0], ends[1][0], "o", ms=4, color=GREY, label="as measured" if k == 0 else None)
        axes.plot(ends[0][1], ends[1][1], "o", ms=4, color=BLUE, label="pooled" if k == 0 else None)
        axes.annotate(name, (ends[0][0], ends[1][0]), xytext=(4, 4), textcoords="offset points", fontsize=7)
    names = [each.path for each in found.population.value]
    axes.set(xlabel=names[0], ylabel=names[second], title="Fingers")
    axes.legend()
    return figure


TITLES = {
    "load": "Load cells",
    "position": "Position",
    "scale": "Amplitude",
    "plate": "Plate",
    "carrier": "Carrier",
    "delay": "Delay",
    "amplitude": "Finger under amplitude commands",
}
DRAWINGS: dict[str, dict[str, Callable[[Mapping[str, Any]], Figure]]] = {
    "position": {"pairs": pairs},
    "scale": {"pairs": pairs},
    "plate": {"sweep": sweep, "decay": decay, "envelope": envelope},
    "carrier": {"drift": drift},
    "delay": {"answer": answer},
    "amplitude": {"law": law},
}
