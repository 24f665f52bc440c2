"""Ranges that are usual for fingers and displays, by a parameter's name, and what a wrong prefix probably meant."""

from __future__ import annotations

import math
from typing import Any

from frictionloop.quantities import unit_of

USUAL = {
    "nominal_n": (0.01, 20.0),
    "susceptibility_per_um2": (1e-3, 50.0),
    "max_amplitude_um": (0.05, 50.0),
    "cutoff_hz": (1.0, 1e5),
    "frequency_hz": (0.01, 2e5),
    "resonance_hz": (5.0, 1e4),
    "moving_mass_kg": (1e-3, 10.0),
    "noise_rms_n": (1e-8, 0.5),
    "noise_density_n_rthz": (1e-9, 3e-4),
    "range_n": (0.05, 100.0),
    "rate_hz": (100.0, 2e5),
    "delay_s": (1e-7, 0.05),
    "offset_n": (1e-3, 20.0),
    "amplitude_n": (1e-4, 20.0),
    "load_n": (0.01, 20.0),
    "speed_mm_s": (0.5, 1000.0),
    "stroke_mm": (2.0, 1000.0),
    "tremor_um": (0.5, 500.0),
    "tremor_n": (1e-4, 1.0),
    "stiffness_n_m": (20.0, 1e5),
    "mass_kg": (1e-6, 0.01),
}
"""Ranges by a parameter's name, the ends a decade or so beyond what is published of fingers and displays (chosen)."""

USUAL_OF = {
    "plate.frequency_hz": (5e3, 2e5),
    "plate.q": (2.0, 1e5),
    "moving.mass_kg": (1e-3, 10.0),
    "springs.width_mm": (0.5, 500.0),
    "springs.thickness_mm": (0.02, 20.0),
    "electrodes.area_mm2": (1.0, 1e5),
    "electrodes.gap_um": (5.0, 5000.0),
    "excitation.frequency_hz": (1e3, 1e7),
    "geometry.length_mm": (5.0, 2000.0),
    "geometry.width_mm": (5.0, 2000.0),
    "geometry.thickness_mm": (0.1, 20.0),
    "drive.resonance_hz": (5e3, 2e5),
    "disturbance.offset_n": (1e-12, 20.0),  # the mean of what its mean was taken from
    "disturbance.rate_hz": (1.0, 2e6),
    "setpoint.rate_hz": (1.0, 2e6),
}
"""Ranges of those whose name alone does not say: ultrasound, a plate that resonates, and what one builds (chosen)."""
PREFIXES = (1e-6, 1e-3, 1e3, 1e6)


def likely(value: float, low: float, high: float) -> float | None:
    """Return the value in the range that a wrong prefix, as milli or kilo, is nearest to; None if there is none."""
    found = [value * factor for factor in PREFIXES if low <= value * factor <= high]
    middle = math.log(low * high) / 2.0
    return min(found, key=lambda each: abs(math.log(each) - middle), default=None)


def meant_instead(path: str, value: Any) -> str:
    """Return what was probably meant by a number that is refused, behind a semicolon; "" where nothing is near."""
    usual = USUAL.get(path.rpartition(".")[2])
    if usual is None or isinstance(value, bool) or not isinstance(value, (int, float)) or not value:
        return ""
    meant = likely(abs(float(value)), *usual)
    return "" if meant is None else f"; did you mean {meant:g} {unit_of(path)}?"
