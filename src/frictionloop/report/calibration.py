"""The characterisation of Section 3.3 on simulated rigs, analysed as recordings of real ones would be (Fig. 4a, 4b)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from frictionloop import identification as find
from frictionloop.identification.rigs import UP_AND_DOWN_KG, floor_rig, hammer_rig, string_friction_for, weights_rig
from frictionloop.parameters.calibration_bench import CalibrationBench

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
