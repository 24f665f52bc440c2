"""The certificate of a bench: one HTML page with what was measured, from which files, and what is still assumed."""

from __future__ import annotations

import math
import os
import platform
import re
import shutil
from collections.abc import Callable, Mapping
from itertools import count
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup
from matplotlib.figure import Figure

from frictionloop.identification import Bench
from frictionloop.identification.parts.part import Part
from frictionloop.parameters import preset
from frictionloop.parameters.wording import known_names
from frictionloop.quantities import replacing, unit_of
from frictionloop.quantities.version import package_version
from frictionloop.report.importance import importance
from frictionloop.report.style import BLUE, GREY, SILVER, VERMILLION, inline, new_figure, styled, svg

TITLES = {"weights": "Weights", "hits": "Hits", "quiet": "Quiet", "slides": "Slides"}


def write_certificate(found: Bench, path: str | os.PathLike[str]) -> Path | None:
    """Write the certificate; an older one is kept beside it under a number. Return where the older one is.

    Raises
    ------
    FrictionloopError
        For a path that cannot be written.
    """
    target = Path(path)
    page = certificate(found)
    kept = _free(target) if target.exists() else None
    if kept is not None:
        shutil.copy2(target, kept)
    with replacing(target) as beside:
        beside.write_text(page, encoding="utf-8")
    return kept


def _free(target: Path) -> Path:
    """Return the first numbered name beside a file that nothing has."""
    return next(path for k in count(1) if not (path := target.with_name(f"{target.stem}-{k}{target.suffix}")).exists())


def certificate(found: Bench) -> str:
    """Return the page: figures and tables of each measurement, the values, the files, and what is still assumed."""
    environment = Environment(
        loader=PackageLoader("frictionloop.report"),
        autoescape=select_autoescape(default_for_string=True, default=True),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    parts = [(TITLES[part.kind], part, _figures(part, k)) for k, part in enumerate(found.parts)]
    return environment.get_template("certificate.html.jinja").render(
        name=re.sub(r"\.toml$", "", found.project.name),
        version=package_version(),
        python=platform.python_version(),
        values=list(found.measured.values()),
        parts=parts,
        stated=[(name, _value(found, name), said) for name, said in found.stated.items()],
        assumed=_assumed(found),
        important=importance(found),
        peak=lambda ms: "out of reach" if math.isnan(ms) else f"{ms:.2f}" if math.isfinite(ms) else "unstable",
        corner=found.resonance_error,
        files=[each for part in found.parts for each in part.files],
    )


def _value(found: Bench, name: str) -> Any:
    value: Any = found.system
    for word in name.split("."):
        value = getattr(value, word)
    return f"{value:.5g}" if isinstance(value, float) else value


def _assumed(found: Bench) -> list[tuple[str, Any, str]]:
    """Return the numbers of plate, sensor, delay and friction that nobody has measured or stated."""
    blocks = ("friction.", "plate.", "sensor.", "finger.", "controller.delay_s", "controller.rate_hz")
    told = set(found.measured) | set(found.stated)
    names = [name for name in known_names(type(preset("bench")), found.system.model_dump()) if name.startswith(blocks)]
    return [
        (name, _value(found, name), unit_of(name)) for name in names if name not in told and not name.endswith("kind")
    ]


def _figures(part: Part, number: int) -> list[Markup]:
    drawn = {name: draw(part.curves) for name, draw in DRAWINGS[part.kind].items() if name in part.curves}
    return [
        Markup(inline(svg(figure, f"c{number}-{k}"), f"{part.kind}: {name}"))
        for k, (name, figure) in enumerate(drawn.items())
    ]


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
    axes.legend()
    return figure


@styled
def _response(curves: Mapping[str, Any]) -> Figure:
    figure = new_figure(6.2, 3.4)
    top, bottom = figure.subplots(2, 1, sharex=True)
    data = curves["response"]
    top.loglog(data["frequency_hz"], data["magnitude"], color=BLUE)
    bottom.semilogx(data["frequency_hz"], data["coherence"], color=GREY)
    top.set(ylabel="reading per force", title="Frequency response")
    bottom.set(xlabel="frequency (Hz)", ylabel="coherence", ylim=(0, 1.05))
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
    "quiet": {"density": _density},
    "slides": {},
}
