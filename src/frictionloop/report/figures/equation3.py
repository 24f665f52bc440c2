"""Equation (3): what the loop makes of the sensor's noise, over the proportional gain."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from frictionloop.report.numbers import number
from frictionloop.report.steady import TONE_HZ
from frictionloop.report.style import BLACK, BLUE, GREEN, GREY, VERMILLION, new_figure, styled


@styled
def figure_equation_3(gain: xr.Dataset) -> Figure:
    """Return the noise gain of force and command: simulated, exact, and equation (3) at one frequency."""
    figure = new_figure(5.6, 4.0)
    axes = figure.subplots()
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
