"""Claims of Sec. 3.3 about the sensor as it was characterised, Fig. 4a and 4b, against the simulated rigs."""

from __future__ import annotations

import math

from frictionloop.hardware.sensor.noise_budget import noise_budget
from frictionloop.identification import dynamic_range_db, floor_readings, residual_share, uniform_std_n
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.report.calibration import BIN_HZ, PRINTED_R2, SHAKING, STILL
from frictionloop.report.claims.claim import Claim, Group, python
from frictionloop.report.claims.sensor import MASS_KG, NOISE_N, RANGE_N, STIFFNESS_N_PER_M
from frictionloop.report.numbers import number
from frictionloop.report.results import Results
from frictionloop.report.tolerances import (
    FLOOR_ACCURACY,
    LAST_DIGIT,
    NOISE_LEVEL,
    RMS_FACTOR,
    as_measured,
    as_printed,
)

RIGS = "from frictionloop.report.calibration import *; "
BELOW_N = 1e-4
"""The floor of the Discussion (paper, Sec. 5)."""


def _linearity(results: Results) -> Claim:
    rigs = results.rigs
    return Claim(
        id="calibration-r2",
        of=Group.DEVICE,
        note=29,
        quantity="R²",
        title="Weights on string and pulley give R² = 0.95",
        place="Sec. 3.3, Fig. 4a",
        quote="a known gravitational force via a string and pulley system … the linear regression shows a goodness "
        "of fit of R² = 0.95",
        published=PRINTED_R2,
        measure="goodness of fit of the simulated calibration",
        readings={"pulley on ball bearings": rigs.weights.r2},
        accepted=as_printed(PRINTED_R2),
        tolerance=LAST_DIGIT,
        explanation=f"A pulley on bearings leaves 1 − R² = {number(1 - rigs.weights.r2, 2)}, most of it the "
        f"curvature of the subtraction. For 0.95 the string would have to rub over a rod that does not turn, with a "
        f"friction of {rigs.rubbing_friction:.3f}: plausible, and then a matter of the rig, not of the sensor. A "
        f"lost digit (0.995, 0.9995) would do as well.",
        command=python(RIGS + "print(all_rigs().weights.r2)"),
    )


def _accuracy(results: Results) -> Claim:
    rigs = results.rigs
    return Claim(
        id="calibration-accuracy",
        of=Group.QUESTION,
        note=29,
        quantity="residuals",
        title="The calibration is as fine as the noise floor",
        place="Sec. 3.3, Fig. 4a and 4b",
        quote="a goodness of fit of R² = 0.95 … a floor at 5·10⁻⁵ N",
        published=NOISE_N,
        unit="N",
        measure="standard deviation of the residuals of the calibration",
        readings={
            "what R² = 0.95 leaves of weights from 0 to 2.5 N": residual_share(PRINTED_R2) * uniform_std_n(RANGE_N),
        },
        compared={"pulley on ball bearings, simulated": rigs.weights.residual_rms_n},
        accepted=(0.0, RMS_FACTOR * NOISE_N),
        tolerance=FLOOR_ACCURACY,
        explanation="R² = 0.95 leaves residuals of 22% of the spread of the loads, three thousand times the floor. A "
        f"floor says how small a change can be seen, not how true the reading is; the simulated sensor is straight to "
        f"{number(1e3 * rigs.weights.residual_rms_n, 2)} mN.",
        command=python("from frictionloop.identification import *; print(residual_share(0.95) * uniform_std_n(2.5))"),
    )


def _resonance(results: Results) -> Claim:
    rigs = results.rigs
    designed = math.sqrt(STIFFNESS_N_PER_M / MASS_KG) / (2 * math.pi)
    return Claim(
        id="hammer-resonance",
        of=Group.CONSTRUCTION,
        note=25,
        quantity="resonance found",
        title="The hammer finds the first resonance at 145 Hz",
        place="Sec. 3.3, Fig. 4b",
        quote="The frequency response shows a first resonance at 145 Hz, owing to the large glass plate",
        published=145.0,
        unit="Hz",
        measure="first resonance",
        readings={"simulated hammer, springs of 0.33 N/µm": rigs.resonance.resonance.value},
        compared={"as designed: 1 N/µm, 0.4 kg (Sec. 3.1)": designed},
        digits=4,
        accepted=as_printed(145.0),
        tolerance=LAST_DIGIT,
        explanation="The bench is built with the measured 145 Hz, so this tells only that hammer and analysis find "
        f"what is there ({rigs.resonance.resonance}). The stiffness and mass of the design give {number(designed)} "
        f"Hz: the paper's two resonances are not of one stiffness and one mass.",
        command=python(RIGS + "print(all_rigs().resonance.resonance.value)"),
    )


def _floor(results: Results) -> Claim:
    rigs = results.rigs
    density = rigs.density_n_rthz(STILL)
    return Claim(
        id="sensor-floor",
        of=Group.CONSTRUCTION,
        note=28,
        quantity="rms noise over the printed",
        title="The sensor's noise floor is 5×10⁻⁵ N",
        place="Sec. 3.3, Fig. 4b",
        quote="a 10s sample without any external perturbation and show a floor at 5·10⁻⁵ N in the low frequency and an "
        "attenuation above 300 Hz",
        published="5×10⁻⁵ N",
        unit="times as much",
        measure="noise of the simulated sensor over the printed number, which is read as the rms of 10 s (N), as a "
        "density (N/√Hz), or as what one bin of 0.1 Hz holds (N); 300 Hz low-pass",
        readings={
            "rms, still base": rigs.rms_n(STILL) / NOISE_N,
            "density, still base": density / NOISE_N,
            "per bin of 0.1 Hz, still base": density * math.sqrt(BIN_HZ) / NOISE_N,
        },
        compared={
            "rms, base shaking 20 µg rms": rigs.rms_n(SHAKING) / NOISE_N,
            "rms, noise budget of the built-in design, 1 kHz": noise_budget(SensorDesign()).rms_n / NOISE_N,
        },
        accepted=as_measured(1.0),
        tolerance=NOISE_LEVEL,
        explanation=f"The simulated sensor has {number(1e6 * rigs.rms_n(STILL), 2)} µN rms, {number(1e6 * density, 2)} "
        f"µN/√Hz, {number(1e6 * density * math.sqrt(BIN_HZ), 2)} µN per bin. The bench's density is the printed "
        "number read as an rms below 300 Hz, so the first reading "
        "holds by construction, but for the converter's share. The noise budget, from electrodes, op-amp and "
        "converter, is independent of it and of the same size. An ordinary bench top, 20 µg, is already four times "
        "as loud through 0.4 kg on springs.",
        command=python(RIGS + "print(all_rigs().rms_n(STILL) / 5e-5)"),
    )


def _floor_below(_: Results) -> Claim:
    found = floor_readings()
    return Claim(
        id="floor-below-1e-4",
        note=28,
        quantity="noise below 300 Hz",
        title="The noise is below 10⁻⁴ N",
        place="Sec. 5",
        quote="The custom-built force sensor has a noise floor that falls below 10⁻⁴ N",
        published=BELOW_N,
        unit="N",
        measure="rms noise below 300 Hz if the printed 5·10⁻⁵ N is read as",
        readings={
            "rms": found["rms"].rms_n,
            "density (N/√Hz)": found["density"].rms_n,
            "per bin of 0.1 Hz": found["per bin"].rms_n,
        },
        accepted=(0.0, BELOW_N),
        tolerance="below the printed number",
        explanation="Only as an rms is it below 10⁻⁴ N, and below the 5·10⁻⁴ N that can be felt. As what a spectrum "
        f"shows, the sensor would have {number(1e3 * found['density'].rms_n, 2)} mN (density) or "
        f"{number(1e3 * found['per bin'].rms_n, 2)} mN (bins of a 10 s sample).",
        command=python("from frictionloop.identification import *; print(floor_readings()['rms'].rms_n)"),
    )


def _range(results: Results) -> Claim:
    rigs = results.rigs
    step_db = 20 * math.log10(RMS_FACTOR)
    return Claim(
        id="dynamic-range-measured",
        of=Group.CONSTRUCTION,
        note=27,
        quantity="range over rms noise",
        title="The sensor spans 93 dB below its resonance",
        place="Sec. 3.3",
        quote="The dynamic range of the sensor before its first resonance is 1:50,000 or about 93dB",
        published=93.0,
        unit="dB",
        measure="20 log₁₀ of 2.5 N over the rms noise",
        readings={
            "300 Hz low-pass, still base": dynamic_range_db(RANGE_N, rigs.rms_n(STILL)),
        },
        compared={
            "300 Hz low-pass, base shaking 20 µg rms": dynamic_range_db(RANGE_N, rigs.rms_n(SHAKING)),
            "noise budget of the built-in design": dynamic_range_db(RANGE_N, noise_budget(SensorDesign()).rms_n),
        },
        accepted=(93.0 - step_db, 93.0 + step_db),
        tolerance=NOISE_LEVEL,
        explanation="It takes 16 bits, a quiet excitation and an isolated base: what shakes the base decides, not the "
        "electronics.",
        command=python(
            RIGS + "from frictionloop.identification import *; print(dynamic_range_db(2.5, all_rigs().rms_n(STILL)))"
        ),
    )


CLAIMS = (_linearity, _accuracy, _resonance, _floor, _floor_below, _range)
