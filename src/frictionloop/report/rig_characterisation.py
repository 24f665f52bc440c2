"""Fig. 4a and 4b: the characterisation of Section 3.3 on simulated rigs, analysed as recordings of real ones are."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.constants import g as GRAVITY

from frictionloop import identification as find
from frictionloop.figures.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION, new_figure, styled
from frictionloop.identification import Calibration, floor_readings
from frictionloop.identification.frequency_response import model
from frictionloop.identification.rigs import UP_AND_DOWN_KG, floor_rig, hammer_rig, string_friction_for, weights_rig
from frictionloop.parameters.calibration_bench import CalibrationBench
from frictionloop.report.number_text import number

PRINTED_R2 = 0.95
"""Goodness of fit of Fig. 4a (paper, Sec. 3.3)."""
RUBBING_KG = tuple(round(0.8 * mass, 3) for mass in UP_AND_DOWN_KG)
"""0 to 200 g and back: friction that pulls along then stays within the range."""
FLOORS: dict[str, dict[str, float]] = {
    "1 kHz low-pass": {"sensor.cutoff_hz": 1000.0},
    "300 Hz low-pass": {"sensor.cutoff_hz": 300.0},
    "300 Hz low-pass, still base": {"sensor.cutoff_hz": 300.0, "base.vibration_ug": 0.0},
}
"""Low-pass of the demodulator (paper, Sec. 3.2) and roll-off of the noise (Sec. 3.3); the base shakes by 20 ug rms."""
SHAKING, STILL = "300 Hz low-pass", "300 Hz low-pass, still base"
BIN_HZ = 0.1
"""Distance of the frequencies of a 10 s sample (paper, Sec. 3.3)."""
FLAT_HZ = (20.0, 100.0)
"""Band below the resonance in which a floor is read off (assumed)."""


class Rigs(NamedTuple):
    """What weights, hammer and silence tell of the sensor."""

    weights: find.Calibration
    """With a pulley on ball bearings."""
    rubbing: find.Calibration
    """With a string that rubs over a fixed rod as strongly as an R2 of 0.95 takes."""
    rubbing_friction: float
    """Friction of that string."""
    response: find.FrequencyResponse
    resonance: find.Resonance
    floors: dict[str, xr.Dataset]
    """Ten seconds without a finger, by the names of ``FLOORS``."""

    def spectrum(self, name: str) -> find.NoiseSpectrum:
        """Return the noise spectrum of one floor."""
        return find.noise_spectrum(self.floors[name])

    def rms_n(self, name: str) -> float:
        """Return the standard deviation of one floor in N, its offset taken off."""
        return float(self.floors[name]["f_m"].std())

    def density_n_rthz(self, name: str) -> float:
        """Return the density of one floor below the resonance, N/rtHz."""
        return find.floor_density(self.spectrum(name), *FLAT_HZ).value


def loads_n() -> np.ndarray:
    """Return the forces of the calibration with a rubbing string, each once."""
    return np.unique(RUBBING_KG) * CalibrationBench().weights.gravity_m_s2


def rubbing_bench() -> CalibrationBench:
    """Return the bench whose string rubs on a rod that does not turn, so that R2 falls to the printed 0.95."""
    friction = string_friction_for(find.exponent_for_r2(PRINTED_R2, loads_n().tolist()))
    # A bearing that cannot turn: the string has to slide.
    return CalibrationBench().evolve({"pulley.string_friction": friction, "pulley.bearing_friction": 1e3})


def all_rigs() -> Rigs:
    """Return the three measurements with the default bench; seeds 0."""
    rubbing, response = rubbing_bench(), find.response(hammer_rig())
    return Rigs(
        find.weights(weights_rig()),
        find.weights(weights_rig(RUBBING_KG, rubbing)),
        rubbing.pulley.string_friction,
        response,
        find.fit_resonance(response),
        {name: floor_rig(CalibrationBench().evolve(changes)) for name, changes in FLOORS.items()},
    )


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
    rubbed = f"rubbing string, friction {number(rigs.rubbing_friction, 2)}"
    for column, (found, title) in enumerate(((rigs.weights, "pulley on ball bearings"), (rigs.rubbing, rubbed))):
        _weighed(panels[0, column], panels[1, column], found)
        panels[0, column].set(ylabel="reading (N)", title=title)
        panels[1, column].set(ylabel="residual (mN)", xlabel="pull of the weights (N)")
    return figure


def _weighed(axes: Axes, below: Axes, found: Calibration) -> None:
    """Draw readings with their line, and below what the line leaves."""
    force, ends = found.steps.mass_kg * GRAVITY, np.array([0.0, 2.5])
    axes.plot(ends, found.offset.value + found.sensitivity.value * ends, color=BLACK, lw=1.1, label="linear regression")
    below.axhline(0, color=BLACK, lw=0.8)
    for way, marker, color, words in WAYS:
        part = found.steps.direction == way
        look: dict[str, Any] = {"marker": marker, "color": color, "mfc": "white", "ls": "none"}
        axes.plot(force[part], found.steps.reading[part], ms=5, label=words, **look)
        below.plot(force[part], 1e3 * found.residuals_n[part], ms=4, **look)
    missing = 1 - found.r2
    r2 = f"{found.r2:.2f}" if missing > 1e-3 else f"1 − {number(missing, 2)}"
    axes.text(0.97, 0.06, f"$R^2$ = {r2}", transform=axes.transAxes, ha="right", va="bottom")
    axes.legend(loc="upper left")


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
    words = f"{found.hits} hits, simulated"
    axes.plot(found.frequency_hz[sure], np.abs(found.response[sure]), "o", ms=2.4, color=BLUE, mew=0, label=words)
    frequency = np.geomspace(5, 500, 2000)
    x = np.array([np.log(fit.gain.value), np.log(fit.resonance.value), np.log(fit.q.value), fit.lag.value])
    fitted = f"fit: {fit.resonance.value:.1f} Hz, Q {fit.q.value:.1f}"
    axes.plot(frequency, np.abs(model(frequency, x)), color=BLACK, lw=1.0, label=fitted)
    axes.axvline(250, color=GREY, ls=":", lw=1.2)
    axes.text(260, 14, "250 Hz,\ndesigned", fontsize=7.5, va="top")
    axes.set(xscale="log", yscale="log", xlim=(5, 500), ylim=(0.05, 30))
    axes.set(xlabel="frequency (Hz)", ylabel="reading over force (N/N)")
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
    axes.set_title("noise without a finger")
    axes.legend(loc="upper right", fontsize=7.5)


def _ticks(axes: Axes, at: tuple[float, ...]) -> None:
    axes.set_xticks(at, [number(x) for x in at])
    axes.minorticks_off()
