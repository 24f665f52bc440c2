"""What a finger does to the vibration: it damps the mode, more on an antinode than on a nodal line.

A contact at x takes from the mode as its resistance times F(x), the mean of cos^2(k x) over the contact:
F = (1 + s cos 2kx)/2, s = 2 J1(k d)/(k d) for a round contact of diameter d. F has the period of half a wavelength.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import j1

from frictionloop.parameters.plate_design import PlateDesign


@dataclass(frozen=True)
class FingerEffect:
    """A finger anywhere on the plate."""

    amplitude_on_touch: float
    """Amplitude of the antinodes over that without a finger, at the mean F = 1/2."""
    quality_on_touch: float
    """Q at that place."""
    plate_ripple: float
    """Amplitude of the antinodes along a stroke, (max - min)/(max + min)."""
    felt_ripple: float
    """Rms amplitude under the contact along a stroke, likewise: what the finger's friction follows."""


def mode_factor(position_mm: np.ndarray | float, half_wavelength_mm: float, contact_mm: float) -> np.ndarray:
    """Return F, the mean of cos^2(k x) under a round contact, whose centre is so far from an antinode."""
    k = math.pi / half_wavelength_mm
    spread = 2 * j1(k * contact_mm) / (k * contact_mm)
    return np.asarray((1 + spread * np.cos(2 * k * np.asarray(position_mm))) / 2)


def amplitude_left(factor: np.ndarray | float, plate_n_s_per_m: float, finger_n_s_per_m: float) -> np.ndarray:
    """Return R_p/(R_p + F R_f): amplitude of the antinodes with a finger over that without, drive unchanged.

    R_p = M omega/Q is the plate's own damping.
    """
    return np.asarray(plate_n_s_per_m / (plate_n_s_per_m + np.asarray(factor) * finger_n_s_per_m))


def finger_effect(design: PlateDesign, plate_n_s_per_m: float, half_wavelength_mm: float) -> FingerEffect:
    """Return what the finger of a design changes; the other arguments as in ``amplitude_left`` and ``mode_factor``."""
    finger, quality = design.finger, design.drive.quality_factor
    mean = float(amplitude_left(0.5, plate_n_s_per_m, finger.resistance_n_s_per_m))
    along_mm = np.linspace(0.0, half_wavelength_mm, 721)
    factor = mode_factor(along_mm, half_wavelength_mm, finger.contact_mm)
    plate = amplitude_left(factor, plate_n_s_per_m, finger.resistance_n_s_per_m)
    return FingerEffect(mean, quality * mean, _ripple(plate), _ripple(plate * np.sqrt(factor)))


def _ripple(values: np.ndarray) -> float:
    return float((values.max() - values.min()) / (values.max() + values.min()))
