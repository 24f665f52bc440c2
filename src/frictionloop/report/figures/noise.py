"""Fig. 2e, 2f and equation (3): fidelity and saturation against sensor noise, and what the loop makes of the noise."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from frictionloop.figures.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION, one_panel, styled
from frictionloop.report.noise import NOISE_READINGS, TONE_HZ
from frictionloop.report.numbers import number

LINES: tuple[dict[str, Any], ...] = ({"color": BLUE, "ls": "-"}, {"color": VERMILLION, "ls": "--"})


@styled
def figure_noise(
    sweeps: Mapping[str, xr.Dataset], metric: str, label: str, limits: tuple[float, float], words: str
) -> Figure:
    """Return a metric over noise for each system: the median over seeds, a band from least to largest, and marks.

    The words of the marks stand at the ``words`` ("top" or "bottom") of the panel.
    """
    figure, axes = one_panel(4.6, 3.7)
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


@styled
def figure_equation_3(gain: xr.Dataset) -> Figure:
    """Return the noise gain of force and command: simulated, exact, and equation (3) at one frequency."""
    figure, axes = one_panel(4.8, 3.7)
    limit = float(gain["kp_limit"])
    axes.axvspan(limit, 60, color="#e2e2e2", lw=0)
    axes.axhline(10, color=GREY, ls=":", lw=1.1)
    axes.plot(gain["kp"], gain["exact_u"], color=VERMILLION, label="command $u$, exact")
    axes.plot(
        gain["kp_simulated"], gain["simulated_u"], "s", color=VERMILLION, mfc="white", label="command $u$, simulated"
    )
    axes.plot(gain["kp"], gain["exact_f"], color=BLUE, label="force $f_a$, exact")
    axes.plot(gain["kp_simulated"], gain["simulated_f"], "o", color=BLUE, mfc="white", label="force $f_a$, simulated")
    axes.plot(gain["kp"], gain["tone"], "--", color=GREEN, label=f"eq. (3) at {number(TONE_HZ)} Hz only")
    axes.set(xscale="log", yscale="log", xlim=(0.5, 60), ylim=(0.08, 2e5))
    axes.set(xlabel="proportional gain $K_p$", ylabel="noise out / sensor noise (N/N)")
    for which in (axes.xaxis, axes.yaxis):
        which.set_major_formatter(FuncFormatter(lambda x, _: number(x)))
    axes.set_xticks([0.5, 1, 2, 5, 10, 20, 50])
    axes.minorticks_off()
    axes.text(0.53, 11.5, "one order of magnitude", fontsize=7.5, color=BLACK)
    axes.text(limit * 1.06, 0.1, f"linear loop\nunstable,\n$K_p$ > {limit:.1f}", fontsize=7.5, color=BLACK, va="bottom")
    axes.text(17.5, 1e4, "limit cycle", fontsize=7.5, color=BLACK, ha="right", va="center")
    axes.legend(loc="upper left")
    return figure
