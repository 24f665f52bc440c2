"""Modes of a plate with free edges: N nodal lines along one side, none along the other (N x 0).

Between free edges the standing wave has k = (2N - 1) pi/(2L): the roots of cos(kL) cosh(kL) = 1 to 0.4 % for N = 2 and
far better from N = 3 on. Half a wavelength is L/(N - 1/2).

The paper's plate: 3 mm, 46 kHz and "16x0" cannot all hold, so any two are kept and the third is solved for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import get_args

from scipy.optimize import brentq

from frictionloop.hardware.plate.dispersion import Theory, frequency_hz, wave_number_per_m
from frictionloop.hardware.plate.drive import plate_mass_kg
from frictionloop.parameters.plate_design import Glass, PlateDesign, PlateGeometry, Side
from frictionloop.quantities import must_be
from frictionloop.quantities.checks import ABOVE_0, number

THICKNESS_MM, FREQUENCY_HZ, LINES = 3.0, 46e3, 16
"""As printed (paper, Sec. 4.1: 255 x 140 x 3 mm3, 46 kHz, 16x0)."""
PRINTED_TO_MM, PRINTED_TO_HZ = 0.5, 500.0
"""Half of the last digit printed: a value this near is the printed one, rounded."""


def check_mode(nodal_lines: int, side_mm: float, thickness_mm: float) -> None:
    """Refuse a mode that the plate cannot have: fewer lines than bending needs, or shorter than the glass is thick."""
    number("side_mm", side_mm, "mm", ABOVE_0)
    number("thickness_mm", thickness_mm, "mm", ABOVE_0)
    if not thickness_mm < side_mm / 1.5:
        raise must_be("thickness_mm", thickness_mm, f"below {side_mm / 1.5:g}", "mm")
    most = most_lines(side_mm, thickness_mm)
    if int(nodal_lines) != nodal_lines or not 2 <= nodal_lines <= most:
        raise must_be("nodal_lines", nodal_lines, f"whole, 2 to {most}")


def most_lines(side_mm: float, thickness_mm: float) -> int:
    """Return the most nodal lines at which half a wavelength, L/(N - 1/2), is not shorter than the thickness."""
    return math.floor(side_mm / thickness_mm * (1 + 1e-12) + 0.5)


@dataclass(frozen=True)
class PlateMode:
    """One mode of one plate."""

    nodal_lines: int
    """N."""
    side_mm: float
    """Side along which the lines follow each other."""
    thickness_mm: float
    """Thickness of the glass."""
    half_wavelength_mm: float
    """Distance between nodal lines."""
    frequency_hz: float
    """Resonance by the theory asked for."""


def mode(nodal_lines: int, side_mm: float, thickness_mm: float, glass: Glass, theory: Theory = "lamb") -> PlateMode:
    """Return the mode with N nodal lines.

    Parameters
    ----------
    nodal_lines : int
        N >= 2, at most as many as leave half a wavelength no shorter than the thickness.
    side_mm, thickness_mm : float
        Side along which the lines follow each other and thickness, in mm.
    glass : Glass
        Material.
    theory : {"lamb", "mindlin", "thin"}
        Exact by default.

    Raises
    ------
    FrictionloopError
        For a mode that the plate cannot have.
    """
    check_mode(nodal_lines, side_mm, thickness_mm)
    half_mm = side_mm / (nodal_lines - 0.5)
    found = frequency_hz(math.pi / (half_mm * 1e-3), thickness_mm, glass, theory)
    return PlateMode(int(nodal_lines), side_mm, thickness_mm, half_mm, found)


def mode_of(design: PlateDesign, theory: Theory = "lamb") -> PlateMode:
    """Return the mode that a design names."""
    geometry = design.geometry
    return mode(geometry.nodal_lines, geometry.side_mm, geometry.thickness_mm, design.glass, theory)


def resonance_hz(design: PlateDesign) -> float:
    """Return the measured resonance of a design, or its mode's frequency if none is given."""
    calculated = mode_of(design).frequency_hz  # refuses an impossible mode in either case
    return design.drive.resonance_hz or calculated


def nearest_mode(frequency: float, side_mm: float, thickness_mm: float, glass: Glass) -> PlateMode:
    """Return the mode whose exact frequency is nearest to a frequency in Hz.

    Raises
    ------
    FrictionloopError
        For a frequency above the highest mode that counts as bending (half a wavelength as short as the thickness).
    """
    check_mode(2, side_mm, thickness_mm)
    highest = mode(most_lines(side_mm, thickness_mm), side_mm, thickness_mm, glass)
    number("frequency_hz", frequency, "Hz", ABOVE_0)
    if frequency > highest.frequency_hz:
        raise must_be(
            "frequency_hz", float(frequency), f"at most {math.floor(highest.frequency_hz)} on this glass", "Hz"
        )
    lines = wave_number_per_m(frequency, thickness_mm, glass) * side_mm * 1e-3 / math.pi + 0.5
    around = {min(max(n, 2), highest.nodal_lines) for n in (math.floor(lines), math.ceil(lines))}
    modes = [mode(n, side_mm, thickness_mm, glass) for n in sorted(around)]
    return min(modes, key=lambda found: abs(found.frequency_hz - frequency))


def thickness_for_mm(
    frequency: float, nodal_lines: int, side_mm: float, glass: Glass, theory: Theory = "lamb"
) -> float:
    """Return the thickness in mm at which N nodal lines along a side vibrate at a frequency in Hz.

    Raises
    ------
    FrictionloopError
        For a frequency that no thickness up to half a wavelength reaches.
    """
    number("frequency_hz", frequency, "Hz", ABOVE_0)
    number("side_mm", side_mm, "mm", ABOVE_0)
    check_mode(nodal_lines, side_mm, side_mm * 1e-6)
    half_mm = side_mm / (nodal_lines - 0.5)
    k = math.pi / (half_mm * 1e-3)
    highest = frequency_hz(k, half_mm, glass, theory)
    if frequency > highest:
        accepted = f"at most {math.floor(highest)}"
        raise must_be("frequency_hz", float(frequency), accepted, "Hz")
    # Thin-plate theory is proportional to h and too high, so its thickness is too small.
    thin_mm = frequency / frequency_hz(k, 1.0, glass, "thin")
    low_mm = thin_mm * (1 - 1e-9)
    return float(brentq(lambda h: frequency_hz(k, h, glass, theory) - frequency, low_mm, half_mm, rtol=1e-13))


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
