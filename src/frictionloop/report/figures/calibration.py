"""Fig. 4a and 4b: weights, hammer and noise of the sensor, from the simulated rigs."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.constants import g as GRAVITY

from frictionloop.figures.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION, new_figure, styled
from frictionloop.identification import Calibration, floor_readings
from frictionloop.identification.resonance import model
from frictionloop.report.calibration import FLOORS, Rigs
from frictionloop.report.numbers import number

WAYS = (
    (1, "^", BLUE, "weights put on"),
    (-1, "v", VERMILLION, "weights taken off"),
    (0, "o", GREY, "first zero"),
)
"""Directions of a calibration's steps, how they are marked, and their words."""


@styled
def figure_linearity(rigs: Rigs) -> Figure:
    """Return reading against weight for a pulley on bearings and for a string that rubs, with the residuals below."""
    figure = new_figure(9.2, 4.2)
    panels = figure.subplots(2, 2, height_ratios=(1.7, 1), sharex=True)
    rubbed = f"string rubs on a rod, friction {number(rigs.rubbing_friction, 2)}"
    for column, (found, title) in enumerate(((rigs.weights, "pulley on ball bearings"), (rigs.rubbing, rubbed))):
        _line(panels[0, column], found, title)
        _residuals(panels[1, column], found)
        panels[0, column].set_ylabel("reading (N)")
        panels[1, column].set_ylabel("residual (mN)")
    return figure


def _line(axes: Axes, found: Calibration, title: str) -> None:
    force = found.steps.mass_kg * GRAVITY
    ends = np.array([0.0, 2.5])
    axes.plot(ends, found.offset.value + found.sensitivity.value * ends, color=BLACK, lw=1.1, label="linear regression")
    for way, marker, color, words in WAYS:
        part = found.steps.direction == way
        axes.plot(
            force[part], found.steps.reading[part], marker, color=color, mfc="white", ms=5, ls="none", label=words
        )
    missing = 1 - found.r2
    r2 = f"{found.r2:.2f}" if missing > 1e-3 else f"1 − {number(missing, 2)}"
    axes.text(0.97, 0.06, f"$R^2$ = {r2}", transform=axes.transAxes, ha="right", va="bottom")
    axes.set_title(title)
    axes.legend(loc="upper left")


def _residuals(axes: Axes, found: Calibration) -> None:
    force = found.steps.mass_kg * GRAVITY
    for way, marker, color, _ in WAYS:
        part = found.steps.direction == way
        axes.plot(force[part], 1e3 * found.residuals_n[part], marker, color=color, mfc="white", ms=4, ls="none")
    axes.axhline(0, color=BLACK, lw=0.8)
    axes.set_xlabel("pull of the weights (N)")


@styled
def figure_spectrum(rigs: Rigs) -> Figure:
    """Return the response to the hammer, and the noise with what the printed floor may stand for."""
    figure = new_figure(9.2, 3.7)
    left, right = figure.subplots(1, 2)
    _response(left, rigs)
    _noise(right, rigs)
    return figure


def _response(axes: Axes, rigs: Rigs) -> None:
    found, fit = rigs.response, rigs.resonance
    sure = (found.coherence > 0.9) & (found.frequency_hz <= 450)
    axes.plot(
        found.frequency_hz[sure],
        np.abs(found.response[sure]),
        "o",
        ms=2.4,
        color=BLUE,
        mew=0,
        label=f"{found.hits} hits, simulated",
    )
    frequency = np.geomspace(5, 500, 2000)
    x = np.array([np.log(fit.gain.value), np.log(fit.resonance.value), np.log(fit.q.value), fit.lag.value])
    axes.plot(
        frequency,
        np.abs(model(frequency, x)),
        color=BLACK,
        lw=1.0,
        label=f"fit: {fit.resonance.value:.1f} Hz, Q {fit.q.value:.1f}",
    )
    axes.axvline(250, color=GREY, ls=":", lw=1.2)
    axes.text(260, 14, "250 Hz,\ndesigned", fontsize=7.5, va="top")
    axes.set(
        xscale="log",
        yscale="log",
        xlim=(5, 500),
        ylim=(0.05, 30),
        xlabel="frequency (Hz)",
        ylabel="reading over force (N/N)",
    )
    _ticks(axes, (5, 10, 20, 50, 100, 200, 500))
    axes.set_title("impact hammer")
    axes.legend(loc="lower left")


def _noise(axes: Axes, rigs: Rigs) -> None:
    looks = ((VERMILLION, "-"), (BLUE, (0, (5, 2))), (GREEN, "-"))
    for name, (color, dashes) in zip(FLOORS, looks, strict=True):
        spectrum = rigs.spectrum(name)
        words = name if "still" in name else f"{name}, base 20 µg"
        axes.plot(spectrum.frequency_hz, spectrum.density, color=color, ls=dashes, lw=0.8, alpha=0.9, label=words)
    marks = {"per bin": PURPLE, "density": ORANGE, "rms": BLACK}
    readings = {"per bin": "5×10⁻⁵ N per 0.1 Hz bin", "density": "5×10⁻⁵ N/√Hz", "rms": "5×10⁻⁵ N rms below 300 Hz"}
    for name, reading in floor_readings().items():
        if name in marks:
            axes.axhline(reading.density_n_rthz, color=marks[name], ls="--", lw=1.1)
            below = 0.6 if name == "rms" else 0.9  # room for the noise that lies on this line
            axes.text(2.2, reading.density_n_rthz * below, readings[name], fontsize=7.5, va="top", color=BLACK)
    axes.set(xscale="log", yscale="log", xlim=(2, 2500), ylim=(2e-7, 1e-3), xlabel="frequency (Hz)")
    axes.set_ylabel("noise of the reading (N/√Hz)")
    _ticks(axes, (2, 10, 100, 1000))
    axes.set_title("noise without a finger, and the printed floor")
    axes.legend(loc="upper right", fontsize=7.5)


def _ticks(axes: Axes, at: tuple[float, ...]) -> None:
    axes.set_xticks(at, [number(x) for x in at])
    axes.minorticks_off()
