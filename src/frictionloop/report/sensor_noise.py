"""Fig. 2e, 2f and equation (3): fidelity, saturation, force and command against sensor noise.

What a printed "noise level" may mean, and sensor noise with everything else held: equation (3) against the simulation.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from frictionloop.analysis import command_noise_rms_n, equation_3_rms_n, kp_limit, linearise, output_noise_rms_n
from frictionloop.figures.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION, one_panel, styled
from frictionloop.loop.simulate import simulate
from frictionloop.loop.sweep import sweep
from frictionloop.parameters import System
from frictionloop.report.number_text import number
from frictionloop.report.system_comparison import at_means
from frictionloop.report.tolerances import R2_STEP

NOISE = "sensor.noise_rms_n"
LEVELS_N = np.geomspace(1e-6, 1.0, 49)
"""Standard deviation of the noise, N, one draw per control period; eight to the decade."""
SEEDS = 8
NO_STEP = 1e-6
"""Share of a step that is as good as none (chosen), as a power has no zero."""
DURATION_S = 10.0
RATE_HZ = 5000.0
"""Rate of the draws (paper, Sec. 4.1)."""
BAND_HZ = RATE_HZ / 2
"""Band of a one-sided density: all that draws at this rate can hold."""


class NoiseReading(NamedTuple):
    """What a printed noise level of 10^-4 may be: its unit, and the standard deviation in N that it stands for."""

    unit: str
    sigma_n: Callable[[float], float]
    level: Callable[[float], float]


NOISE_READINGS: dict[str, NoiseReading] = {
    "rms": NoiseReading("N", lambda level: level, lambda sigma: sigma),
    "variance": NoiseReading("N²", math.sqrt, lambda sigma: sigma**2),
    "amplitude density": NoiseReading(
        "N/√Hz one-sided", lambda level: level * math.sqrt(BAND_HZ), lambda sigma: sigma / math.sqrt(BAND_HZ)
    ),
    "power density": NoiseReading(
        "N²/Hz one-sided", lambda level: math.sqrt(level * BAND_HZ), lambda sigma: sigma**2 / BAND_HZ
    ),
}
"""rms; variance (as random-number blocks ask for); densities, both one-sided over 0 to 2.5 kHz."""


def noise_sweep(system: System) -> xr.Dataset:
    """Return r2_identity and saturation_index over ``sigma`` (N) and ``seed``."""
    found = sweep(system, {NOISE: LEVELS_N}, DURATION_S, SEEDS, ["r2_identity", "saturation_index"], progress=False)
    return found.rename({NOISE: "sigma"})


def knee_n(metric: xr.DataArray, step: float = R2_STEP) -> float | None:
    """Return the noise (N rms) at which the median of a metric has moved by ``step`` from its value without noise.

    It is taken to move as a power of sigma between two points; None if it never moves that far.
    """
    median = metric.median("seed")
    moved = np.abs(median.values - median.values[0])
    beyond = np.flatnonzero(moved >= step)
    if beyond.size == 0:
        return None
    k = int(beyond[0])
    x = np.log(median["sigma"].values)
    y = np.log(np.maximum(moved[k - 1 : k + 1], step * NO_STEP))
    return math.exp(float(np.interp(math.log(step), y, x[k - 1 : k + 1])))


SIMULATED_KPS = (1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 14.0, 18.0, 20.0, 40.0)
HELD_S, SCORED_S = 200.0, 40.0
"""The integral settles with (1 + Kp)/Ki, 10 s at most below the limit cycle; the rest is scored."""
TONE_HZ = 1.0
"""Where equation (3) is read as printed: the frequency of the disturbance (assumed)."""


def steady_noise(system: System) -> dict[str, float]:
    """Return the standard deviations of f_a and u (N) with set-point and disturbance held, from a simulation."""
    run = simulate(at_means(system), HELD_S)
    scored = run.isel(time=slice(-round(SCORED_S * system.controller.rate_hz), None))
    return {name: float(scored[name].std()) for name in ("f_a", "u")}


def noise_gain(system: System) -> xr.Dataset:
    """Return sigma_f / sigma_n and sigma_u / sigma_n over kp: simulated, exact, and by equation (3) at one frequency.

    ``simulated_f``, ``simulated_u`` lie over ``kp_simulated``; ``exact_f``, ``exact_u`` (discrete Lyapunov equation)
    and ``tone`` (|G/(1+G)| at 1 Hz) over ``kp``, up to ``kp_limit``.
    """
    limit = kp_limit(system)
    kps = np.geomspace(0.5, 0.999 * limit, 60)
    linear = [linear_gain(system.evolve({"controller.kp": kp})) for kp in kps]
    sigma = system.sensor.noise_rms_n
    simulated = [steady_noise(system.evolve({"controller.kp": kp})) for kp in SIMULATED_KPS]
    return xr.Dataset(
        {
            "exact_f": ("kp", [gain["f_a"] for gain in linear]),
            "exact_u": ("kp", [gain["u"] for gain in linear]),
            "tone": ("kp", [gain["tone"] for gain in linear]),
            "simulated_f": ("kp_simulated", [noise["f_a"] / sigma for noise in simulated]),
            "simulated_u": ("kp_simulated", [noise["u"] / sigma for noise in simulated]),
            "kp_limit": limit,
        },
        {"kp": kps, "kp_simulated": list(SIMULATED_KPS)},
    )


def linear_gain(system: System) -> dict[str, float]:
    """Return sigma_f / sigma_n, sigma_u / sigma_n and |G/(1+G)| at 1 Hz of the linear loop, N/N."""
    loop, sigma = linearise(at_means(system)), system.sensor.noise_rms_n
    tone = float(equation_3_rms_n(loop, [TONE_HZ])[0])
    return {"f_a": output_noise_rms_n(loop) / sigma, "u": command_noise_rms_n(loop) / sigma, "tone": tone / sigma}


LINES: tuple[dict[str, Any], ...] = ({"color": BLUE, "ls": "-"}, {"color": VERMILLION, "ls": "--"})


@styled
def figure_noise(
    sweeps: Mapping[str, xr.Dataset], metric: str, label: str, limits: tuple[float, float], words: str
) -> Figure:
    """Return a metric over noise for each system: the median over seeds, a band from least to largest, and marks.

    The words of the marks stand at the ``words`` ("top" or "bottom") of the panel.
    """
    figure, axes = one_panel(4.6, 3.7)
    for line, (name, found) in zip(LINES, sweeps.items(), strict=False):
        values = found[metric].clip(*limits)
        axes.fill_between(found["sigma"], values.min("seed"), values.max("seed"), color=line["color"], alpha=0.25, lw=0)
        axes.plot(found["sigma"], values.median("seed"), **line, label=name)
    axes.set(xscale="log", xlim=(1e-6, 1), ylim=limits)
    axes.set(xlabel="sensor noise, standard deviation (N)", ylabel=label)
    # A white ground keeps the words readable where a curve passes.
    ground = {"fc": "white", "ec": "none", "alpha": 0.8, "pad": 0.6}
    place: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "xytext": (-1.5, 0), "textcoords": "offset points"}
    look: dict[str, Any] = {"rotation": 90, "ha": "right", "va": words, "fontsize": 7, "color": BLACK, "bbox": ground}
    for level_n, color, dashes, text in marks():
        axes.axvline(level_n, color=color, ls=dashes, lw=1.1, zorder=1)
        axes.annotate(text, (level_n, 0.02 if words == "bottom" else 0.98), **place, **look)
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
