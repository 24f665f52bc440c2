"""Numbers of the claims of Sec. 3, 4.1 and 5 about sensor, timing and plate: formulas and simulated rigs, Fig. 4."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from frictionloop.hardware.plate.modes import plate_readings
from frictionloop.hardware.sensor.noise_budget import noise_budget
from frictionloop.identification import dynamic_range_db as decibels
from frictionloop.identification import floor_readings, residual_share, uniform_std_n
from frictionloop.parameters.plate_design import Side
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.report.claims.claim import Numbers, numbers
from frictionloop.report.results import Results
from frictionloop.report.rig_characterisation import BIN_HZ, PRINTED_R2, SHAKING, STILL

RANGE_N, NOISE_N = 2.5, 5e-5
"""Largest force and noise of the sensor (paper, Sec. 3.1)."""
STIFFNESS_N_PER_M, MASS_KG = 1e6, 0.4
"""Stiffness of the suspension and mass of the plate (paper, Sec. 3.1)."""
MEASURED_HZ = 145.0
"""First resonance (paper, Sec. 3.3)."""
LOWPASS_HZ = 1000.0
"""Cutoff of the demodulator (paper, Sec. 3.2)."""
BUDGET = "noise budget of the built-in design"
SIDES: dict[Side, str] = {"length": "16 lines along 255 mm", "width": "16 lines across 140 mm"}


def _formula(value: float, **told: Any) -> Callable[[Results], Numbers]:
    """Return what gives the number of a claim that is a formula of printed numbers."""
    return lambda _: numbers({"as printed": value}, **told)


DESIGNED_HZ = math.sqrt(STIFFNESS_N_PER_M / MASS_KG) / (2 * math.pi)
_OMEGA2 = (2 * math.pi * MEASURED_HZ) ** 2
dynamic_range = _formula(RANGE_N / NOISE_N)
dynamic_range_db = _formula(20 * math.log10(RANGE_N / NOISE_N), at_95=10 ** (95 / 20), at_93=10 ** (93 / 20))
resonance = _formula(DESIGNED_HZ)
measured_resonance = _formula(STIFFNESS_N_PER_M / _OMEGA2, stiffness=_OMEGA2 * MASS_KG / 1e6)
displacement = _formula(2.0 / STIFFNESS_N_PER_M * 1e6)
control_period = _formula(1e3 / 5000.0)


def displacement_noise(_: Results) -> Numbers:
    """Return the displacement that the noise is, in pm."""
    rms_pm, bandwidth_hz = NOISE_N / STIFFNESS_N_PER_M * 1e12, math.pi / 2 * LOWPASS_HZ
    density = rms_pm / math.sqrt(bandwidth_hz)
    return numbers({"rms": rms_pm, "density below 1 kHz (pm/√Hz)": density}, density=density)


def calibration_r2(results: Results) -> Numbers:
    """Return the goodness of fit of the simulated calibration."""
    rigs = results.rigs
    return numbers(
        {"pulley on ball bearings": rigs.weights.r2}, missing=1 - rigs.weights.r2, friction=rigs.rubbing_friction
    )


def calibration_accuracy(results: Results) -> Numbers:
    """Return the residuals that the printed goodness of fit leaves, in N."""
    left, simulated = "what R² = 0.95 leaves of weights from 0 to 2.5 N", "pulley on ball bearings, simulated"
    residual_n = results.rigs.weights.residual_rms_n
    found = {left: residual_share(PRINTED_R2) * uniform_std_n(RANGE_N), simulated: residual_n}
    return numbers(found, compared=["simulated"], residual_mn=1e3 * residual_n)


def hammer_resonance(results: Results) -> Numbers:
    """Return the resonance that the simulated hammer finds, in Hz."""
    found, designed = results.rigs.resonance.resonance, "as designed: 1 N/µm, 0.4 kg (Sec. 3.1)"
    hertz = {"simulated hammer, springs of 0.33 N/µm": found.value, designed: DESIGNED_HZ}
    return numbers(hertz, compared=["0.4 kg (Sec. 3.1)"], found=str(found), designed=DESIGNED_HZ)


def sensor_floor(results: Results) -> Numbers:
    """Return the noise of the simulated sensor over the printed number, as each thing that it may be."""
    rigs = results.rigs
    found_n = {
        "rms, still base": rigs.rms_n(STILL),
        "density, still base": rigs.density_n_rthz(STILL),
        "per bin of 0.1 Hz, still base": rigs.density_n_rthz(STILL) * math.sqrt(BIN_HZ),
        "rms, base shaking 20 µg rms": rigs.rms_n(SHAKING),
        f"rms, {BUDGET}, 1 kHz": noise_budget(SensorDesign()).rms_n,
    }
    rms, density, per_bin, *_ = (1e6 * each for each in found_n.values())
    return numbers(
        {name: each / NOISE_N for name, each in found_n.items()},
        compared=["base shaking 20 µg rms", "1 kHz"],
        rms_un=rms,
        density_un=density,
        bin_un=per_bin,
    )


def floor_below_1e_4(_: Results) -> Numbers:
    """Return the rms noise that the printed floor stands for, in N."""
    rms, density, per_bin = (floor_readings()[name].rms_n for name in ("rms", "density", "per bin"))
    return numbers({"rms": rms, "density (N/√Hz)": density, "per bin of 0.1 Hz": per_bin}, bin_mn=1e3 * per_bin)


def dynamic_range_measured(results: Results) -> Numbers:
    """Return the range of the simulated sensor over its noise, in dB."""
    found_n = {
        "300 Hz low-pass, still base": results.rigs.rms_n(STILL),
        "300 Hz low-pass, base shaking 20 µg rms": results.rigs.rms_n(SHAKING),
        BUDGET: noise_budget(SensorDesign()).rms_n,
    }
    compared = ["base shaking 20 µg rms", BUDGET]
    return numbers({name: decibels(RANGE_N, rms_n) for name, rms_n in found_n.items()}, compared=compared)


def plate_mode(_: Results) -> Numbers:
    """Return the frequency of the mode with the printed lines on either side, in kHz."""
    found = {(each.wave_along, each.solved_for): each.mode for each in plate_readings()}
    fits = found["width", "lines"]
    return numbers(
        {words: 1e-3 * found[side, "frequency"].frequency_hz for side, words in SIDES.items()},
        nodal_lines=fits.nodal_lines,
        fits_khz=1e-3 * fits.frequency_hz,
        thick=found["length", "thickness"].thickness_mm,
    )
