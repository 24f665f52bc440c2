"""The paper's plate: 3 mm, 46 kHz and "16x0" cannot all hold, so any two are kept and the third is solved for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

from frictionloop.hardware.plate.drive import plate_mass_kg
from frictionloop.hardware.plate.modes import PlateMode, mode, nearest_mode, thickness_for_mm
from frictionloop.parameters.plate_design import Glass, PlateGeometry, Side

THICKNESS_MM, FREQUENCY_HZ, LINES = 3.0, 46e3, 16
"""As printed (paper, Sec. 4.1: 255 x 140 x 3 mm3, 46 kHz, 16x0)."""
PRINTED_TO_MM, PRINTED_TO_HZ = 0.5, 500.0
"""Half of the last digit printed: a value this near is the printed one, rounded."""


@dataclass(frozen=True)
class PlateReading:
    """A plate that keeps two of the paper's three numbers as far as whole lines allow."""

    wave_along: Side
    """Side along which the nodal lines follow each other."""
    solved_for: str
    """The number given up: "frequency", "lines" or "thickness"."""
    mode: PlateMode
    """The mode so read."""
    mass_kg: float
    """Mass of the glass; the paper says "on the order of" 0.4 kg (Sec. 3.1)."""

    @property
    def agrees(self) -> tuple[str, ...]:
        """Which of "thickness", "frequency" and "lines" are the printed ones to the digits printed."""
        right = {
            "thickness": abs(self.mode.thickness_mm - THICKNESS_MM) < PRINTED_TO_MM,
            "frequency": abs(self.mode.frequency_hz - FREQUENCY_HZ) < PRINTED_TO_HZ,
            "lines": self.mode.nodal_lines == LINES,
        }
        return tuple(name for name, holds in right.items() if holds)


def plate_readings(glass: Glass | None = None) -> tuple[PlateReading, ...]:
    """Return the six readings of the printed plate: each number given up, along either side.

    Parameters
    ----------
    glass : Glass, optional
        Material; the paper says glass only, soda-lime is assumed.

    Returns
    -------
    tuple of PlateReading
        None agrees with all three numbers. 3 mm and 46 kHz agree with each other for 12 lines along the 140 mm side.
    """
    glass = glass or Glass()
    found: list[PlateReading] = []
    for side in get_args(Side):
        side_mm = PlateGeometry(wave_along=side).side_mm
        thickness_mm = thickness_for_mm(FREQUENCY_HZ, LINES, side_mm, glass)
        solved = {
            "frequency": mode(LINES, side_mm, THICKNESS_MM, glass),
            "lines": nearest_mode(FREQUENCY_HZ, side_mm, THICKNESS_MM, glass),
            "thickness": mode(LINES, side_mm, thickness_mm, glass),
        }
        for name, each in solved.items():
            geometry = PlateGeometry(thickness_mm=each.thickness_mm)
            found.append(PlateReading(side, name, each, plate_mass_kg(geometry, glass)))
    return tuple(found)
