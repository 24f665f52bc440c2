"""The figures of a certificate, and of a recording that an analysis refuses."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from io import BytesIO
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from PIL import Image  # matplotlib needs it too

from frictionloop.figures.style import BLUE, GREY, SILVER, VERMILLION, new_figure, one_panel, png, styled
from frictionloop.identification.file_overview import first_look
from frictionloop.identification.finger_population import People
from frictionloop.identification.project_entry_result import Refused
from frictionloop.quantities import FrictionloopError, replacing

Curves = Mapping[str, Any]


def _one(title: str, x: str, y: str, height: float = 2.6) -> tuple[Figure, Axes]:
    """Return a figure with one panel, named."""
    figure, axes = one_panel(6.2, height)
    axes.set(xlabel=x, ylabel=y, title=title)
    return figure, axes


def _over(
    key: str, title: str, x: str, y: str, *, names: tuple[str, str] = ("x", "y"), scale: float = 1e3, few: float = 0.0
) -> Callable[[Curves], Figure]:
    """Return what draws what was measured, and fitted if anything was, over one axis; below ``few`` points as dots."""

    @styled
    def draw(curves: Curves) -> Figure:
        data = curves[key]
        figure, axes = _one(title, x, y.format_map(data))
        place, reading = [scale * each for each in data[names[0]]], data[names[1]]
        axes.plot(place, reading, "o" if len(place) < few else "-", ms=3, lw=0.8, color=BLUE, label="measured")
        if "fitted" in data:
            axes.plot(place, data["fitted"], color=VERMILLION, lw=1.0, label="fitted")
            axes.legend()
        return figure

    return draw


def _line(x: np.ndarray, y: np.ndarray, ends: Any, left: np.ndarray, words: tuple[str, str, str, str]) -> Figure:
    """Return readings with their line, which goes through ``ends``, and beside them what the line leaves."""
    figure = new_figure(6.2, 2.8)
    panel, below = figure.subplots(1, 2)
    panel.plot(x, y, "o", ms=3, color=BLUE)
    panel.plot(*ends, color=VERMILLION, lw=0.8)
    below.plot(x, left, "o", ms=3, color=BLUE)
    below.axhline(0.0, color=VERMILLION, lw=0.8)
    across, up, residual, title = words
    panel.set(xlabel=across, ylabel=up, title=title)
    below.set(xlabel=across, ylabel=residual, title="What the line leaves")
    return figure


@styled
def _weights(curves: Curves) -> Figure:
    force, reading, left = (np.concatenate(curves[name]) for name in ("force_n", "reading", "residual_n"))
    ends = np.array([force.min(), force.max()])
    line = (ends, curves["offset"] + curves["slope"] * ends)
    words = ("force (N)", f"reading ({curves['unit']})", "residual (mN)", "Reading")
    return _line(force, reading, line, 1e3 * left, words)


@styled
def _pairs(curves: Curves) -> Figure:
    data = curves["pairs"]
    x, y, fitted = (np.asarray(data[name]) for name in ("x", "y", "fitted"))
    across, up = data["labels"]
    return _line(x, y, (x, fitted), y - fitted, (across, up, f"residual, {up}", "Scale"))


@styled
def _poles(curves: Curves) -> Figure:
    figure, axes = _one("Poles over order, and modes", "frequency (Hz)", "order")
    for stable, colour, label in ((False, SILVER, "moves with the order"), (True, BLUE, "stays")):
        poles = [(hertz, order) for order, hertz, stays in curves["poles"] if stays is stable]
        axes.plot([p[0] for p in poles], [p[1] for p in poles], "o", ms=3, color=colour, label=label)
    for hertz in curves["modes_hz"]:
        axes.axvline(hertz, color=VERMILLION, lw=0.8)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    if curves["modes_hz"]:
        axes.set_xlim(0, 1.5 * max(curves["modes_hz"]))
    axes.legend()
    return figure


@styled
def _response(curves: Curves) -> Figure:
    data = curves["response"]
    if np.ptp(data["coherence"]) == 0:  # a listed response tells none
        figure, axes = _one("Frequency response", "frequency (Hz)", "reading per force")
        axes.loglog(data["frequency_hz"], data["magnitude"], ".", ms=4, color=BLUE, label="as listed")
    else:
        figure = new_figure(6.2, 3.4)
        axes, below = figure.subplots(2, 1, sharex=True)
        axes.loglog(data["frequency_hz"], data["magnitude"], color=BLUE)
        axes.set(ylabel="reading per force", title="Frequency response")
        below.semilogx(data["frequency_hz"], data["coherence"], color=GREY)
        below.set(xlabel="frequency (Hz)", ylabel="coherence", ylim=(0, 1.05))
    if data.get("fitted"):
        at_hz = data.get("fitted_hz", data["frequency_hz"])
        axes.loglog(at_hz, data["fitted"], color=VERMILLION, lw=0.8, label="fitted")
        axes.legend()
    return figure


@styled
def _slides(curves: Curves) -> Figure:
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
def _density(curves: Curves) -> Figure:
    figure, axes = _one("Noise", "frequency (Hz)", "density (N/√Hz)", 2.8)
    axes.loglog(curves["frequency_hz"], curves["density"], color=BLUE, lw=0.8)
    axes.plot(curves["band_hz"], [curves["level"]] * 2, color=VERMILLION, label="taken for the electronics")
    axes.legend()
    return figure


@styled
def _decay(curves: Curves) -> Figure:
    """Draw a rise or fall of the vibration: its periods are too many to be seen, its envelope is not."""
    data = curves["decay"]
    figure, axes = _one("After the drive was switched", "time (ms)", f"vibration ({data['unit']})")
    time = [1e3 * each for each in data["x"]]
    axes.plot(time, data["y"], color=BLUE, lw=0.4, label="measured")
    left = np.subtract(data["y"], data["fitted"])
    axes.plot(time, left, color=VERMILLION, lw=0.6, label="what the fit leaves")
    axes.legend()
    return figure


@styled
def _laws(curves: Curves) -> Figure:
    """Draw what is left of friction over the amplitude, and the laws."""
    data = curves["law"]
    figure, axes = _one("Laws, the likeliest first", "amplitude (µm)", "share of friction left", 3.0)
    axes.plot(data["amplitude_um"], data["share"], "o", ms=2, color=SILVER, label="0.1 s of a slide")
    looks = zip((VERMILLION, BLUE, GREY), ("-", "--", ":"), strict=True)
    for (name, curve), (colour, style) in zip(data["laws"].items(), looks, strict=True):
        axes.plot(data["fine_um"], curve, style, color=colour, label=name)
    axes.set_ylim(0, None)
    axes.legend()
    return figure


@styled
def crowd(found: People) -> Figure:
    """Draw each finger as measured and as pooled, by its first two values."""
    names, second = [each.path for each in found.population.value], min(1, found.raw.shape[1] - 1)
    figure, axes = _one("Fingers", names[0], names[second], 3.0)
    for k, name in enumerate(found.names):
        ends = [[math.exp(each[k, column]) for each in (found.raw, found.pooled)] for column in (0, second)]
        axes.plot(*ends, color=SILVER, lw=0.8)
        axes.plot(ends[0][0], ends[1][0], "o", ms=4, color=GREY, label="as measured" if k == 0 else None)
        axes.plot(ends[0][1], ends[1][1], "o", ms=4, color=BLUE, label="pooled" if k == 0 else None)
        axes.annotate(name, (ends[0][0], ends[1][0]), xytext=(4, 4), textcoords="offset points", fontsize=7)
    axes.legend()
    return figure


_hit = _over("decay", "The first good hit", "time (ms)", "reading", names=("time_s", "reading"))
_sweep = _over("sweep", "Stepped sine", "frequency (kHz)", "vibration ({unit})", scale=1e-3, few=math.inf)
_envelope = _over("envelope", "After the drive was switched", "time (ms)", "amplitude ({unit})")
_drift = _over("drift", "Drift of the resonance", "time (min)", "resonance − {middle:.0f} Hz (Hz)", scale=1.0, few=60)
_answer = _over("answer", "Answer to the first jump", "time (ms)", "answer")

DRAWINGS: dict[str, dict[str, Callable[[Curves], Figure]]] = {
    "weights": {"force_n": _weights},
    "hits": {"decay": _hit, "poles": _poles, "response": _response},
    "response": {"response": _response},
    "quiet": {"density": _density},
    "load": {"force_n": _weights},
    "slides": {"slides": _slides},
    "recording": {"file": lambda curves: first_look(curves["file"], curves.get("rate_hz")).plot()},
    "position": {"pairs": _pairs},
    "scale": {"pairs": _pairs},
    "plate": {"sweep": _sweep, "decay": _decay, "envelope": _envelope},
    "carrier": {"drift": _drift},
    "delay": {"answer": _answer},
    "amplitude": {"law": _laws},
}
"""By the kind of a measurement, and the name of the curves that are drawn."""


def drawn(kind: str, curves: Curves) -> Iterator[tuple[str, Figure]]:
    """Yield the name and the figure of all curves of a measurement that are there."""
    yield from ((name, draw(curves)) for name, draw in DRAWINGS[kind].items() if name in curves)


def draw_refused(refused: Refused, path: str | os.PathLike[str]) -> Refused:
    """Draw what an analysis saw when it refused, and return the refusal with the picture's name, if anything was drawn.

    Parameters
    ----------
    refused : Refused
        From an analysis of `frictionloop.identification`.
    path : path
        Picture (.png) to write: one figure below the other.

    Raises
    ------
    FrictionloopError
        For a path that cannot be written.
    """
    images = []
    with suppress(FrictionloopError):  # what cannot be drawn is not said in place of the refusal
        images = [Image.open(BytesIO(png(figure))).convert("RGB") for _, figure in drawn(refused.kind, refused.curves)]
    if not images:
        return refused
    page = Image.new("RGB", (max(each.width for each in images), sum(each.height for each in images)), "white")
    top = 0
    for each in images:
        page.paste(each, (0, top))
        top += each.height
    with replacing(path) as beside:
        page.save(beside, format="png")
    return Refused(f"{refused}; picture: {path}", refused.kind, refused.curves)
