"""Fig. 2e and 2f: fidelity and saturation against sensor noise, with what a printed noise level may stand for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from frictionloop.report.noise import NOISE_READINGS
from frictionloop.report.style import BLACK, BLUE, GREY, ORANGE, PURPLE, VERMILLION, new_figure, styled

LINES: tuple[dict[str, Any], ...] = ({"color": BLUE, "ls": "-"}, {"color": VERMILLION, "ls": "--"})


@styled
def figure_noise(
    sweeps: Mapping[str, xr.Dataset], metric: str, label: str, limits: tuple[float, float], words: str
) -> Figure:
    """Return a metric over noise for each system: the median over seeds, a band from least to largest, and marks.

    The words of the marks stand at the ``words`` ("top" or "bottom") of the panel.
    """
    figure = new_figure(4.6, 3.7)
    axes = figure.subplots()
    for line, (name, sweep) in zip(LINES, sweeps.items(), strict=False):
        values = sweep[metric].clip(*limits)
        axes.fill_between(sweep["sigma"], values.min("seed"), values.max("seed"), color=line["color"], alpha=0.25, lw=0)
        axes.plot(sweep["sigma"], values.median("seed"), **line, label=name)
    axes.set(xscale="log", xlim=(1e-6, 1), ylim=limits)
    axes.set(xlabel="sensor noise, standard deviation (N)", ylabel=label)
    for level_n, color, dashes, text in marks():
        _mark(axes, level_n, color, dashes, text, words)
    figure.legend(loc="outside upper left", ncols=2)
    return figure


def marks() -> list[tuple[float, str, str, str]]:
    """Return (standard deviation in N, colour, line style, words) of each printed noise level and its readings."""
    variance, density = NOISE_READINGS["variance"].sigma_n(1e-4), NOISE_READINGS["amplitude density"].sigma_n(1e-4)
    return [
        (1e-5, GREY, ":", "10⁻⁵ N, simulated"),
        (5e-5, GREY, ":", "5×10⁻⁵ N, required"),
        (1e-4, BLACK, "-", "10⁻⁴ N, “harmful”"),
        (density, ORANGE, "-.", "10⁻⁴ N/√Hz"),
        (variance, PURPLE, (0, (4, 1.5)), "10⁻⁴ N²"),  # type: ignore[list-item]
    ]


def _mark(axes: Axes, level_n: float, color: str, dashes: str, text: str, words: str) -> None:
    axes.axvline(level_n, color=color, ls=dashes, lw=1.1, zorder=1)
    # A white ground keeps the words readable where a curve passes.
    ground = {"fc": "white", "ec": "none", "alpha": 0.8, "pad": 0.6}
    place: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "xytext": (-1.5, 0), "textcoords": "offset points"}
    at = (level_n, 0.02 if words == "bottom" else 0.98)
    axes.annotate(text, at, **place, rotation=90, ha="right", va=words, fontsize=7, color=BLACK, bbox=ground)
