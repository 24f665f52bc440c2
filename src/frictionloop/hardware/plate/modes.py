"""Modes of a plate with free edges: N nodal lines along one side, none along the other (N x 0).

Between free edges the standing wave has k = (2N - 1) pi/(2L): the roots of cos(kL) cosh(kL) = 1 to 0.4 % for N = 2 and
far better from N = 3 on. Half a wavelength is L/(N - 1/2).

The paper's plate: 3 mm, 46 kHz and "16x0" cannot all hold, so any two are kept and the third is solved for.

Symbols: k wave number, h thickness, E, nu, rho, G = E/(2(1 + nu)), D = E h^3/(12(1 - nu^2)), cT^2 = G/rho,
gamma = (cT/cL)^2 = (1 - 2 nu)/(2(1 - nu)), xi = k h/2 and x = (omega/(k cT))^2. Plane strain throughout: the wave
runs in one direction and is uniform in the other.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

from scipy.optimize import brentq

from frictionloop.hardware.plate.drive_requirements import plate_mass_kg
from frictionloop.parameters.plate_design import Glass, PlateDesign, PlateGeometry, Side
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.value_checks import ABOVE_0, number

Theory = Literal["lamb", "mindlin", "thin"]
"""Exact elasticity, thick-plate theory, thin-plate theory."""
SHEAR = math.pi**2 / 12
"""Mindlin's shear correction kappa, which gives the exact first thickness-shear frequency (Mindlin 1951)."""
_TANH = (1.0, -1 / 3, 2 / 15, -17 / 315, 62 / 2835, -1382 / 155925, 21844 / 6081075, -929569 / 638512875)
"""tanh(y)/y as a series in y^2."""
_SERIES_BELOW = 0.15
"""xi below which differences of tanh cancel more than this series leaves out (4e-14)."""


def frequency_hz(wave_number_per_m: float, thickness_mm: float, glass: Glass, theory: Theory = "lamb") -> float:
    """Return the frequency of a bending wave.

    Parameters
    ----------
    wave_number_per_m : float
        k > 0 in rad/m.
    thickness_mm : float
        h > 0 in mm.
    glass : Glass
        Material.
    theory : {"lamb", "mindlin", "thin"}
        Exact by default. Thin-plate theory is too high, by more than 10 % where k h > 0.8.

    Raises
    ------
    FrictionloopError
        For another theory.
    """
    if theory not in get_args(Theory):
        accepted = ", ".join(map(repr, get_args(Theory)))
        raise FrictionloopError(f"theory = {theory!r} is unknown; accepted: {accepted}")
    half = wave_number_per_m * thickness_mm * 1e-3 / 2
    root = {"lamb": _lamb, "mindlin": _mindlin, "thin": _thin}[theory](half, glass.poisson_ratio)
    shear_speed = math.sqrt(glass.young_modulus_pa / (2 * (1 + glass.poisson_ratio) * glass.density_kg_per_m3))
    return wave_number_per_m * shear_speed * math.sqrt(root) / (2 * math.pi)


def wave_number_per_m(frequency: float, thickness_mm: float, glass: Glass) -> float:
    """Return the wave number in rad/m of the bending wave of a frequency in Hz, by the exact theory."""
    # Bending waves are slower than thin-plate theory says, so its wave number is too small.
    low = math.sqrt(frequency / frequency_hz(1.0, thickness_mm, glass, "thin")) * (1 - 1e-9)
    high = 2 * low
    while frequency_hz(high, thickness_mm, glass) < frequency:
        high *= 2
    return float(brentq(lambda k: frequency_hz(k, thickness_mm, glass) - frequency, low, high, xtol=1e-12 * low))


def _thin(half: float, nu: float) -> float:
    """Return x of omega^2 = D k^4/(rho h)."""
    return 2 * half * half / (3 * (1 - nu))


def _mindlin(half: float, nu: float) -> float:
    """Return the lower x of (rho h w^2 - kappa G h k^2)(rho h^3 w^2/12 - D k^2 - kappa G h) = (kappa G h k)^2."""
    a = half * half / 3
    c = SHEAR * _thin(half, nu)
    b = _thin(half, nu) + SHEAR * (1 + a)
    return 2 * c / (b + math.sqrt(b * b - 4 * a * c))


def _lamb(half: float, nu: float) -> float:
    """Return the root x in (0, 1) of the antisymmetric Rayleigh-Lamb equation (Graff, Wave Motion, 1975, Sec. 8.1).

    (2 - x)^2 tanh(xi a) = 4 a b tanh(xi b), a^2 = 1 - gamma x, b^2 = 1 - x, has a root x = 0 that is no wave. With
    T(y) = tanh(y)/y and (2 - x)^2 = 4 b^2 + x^2 it divides out: x T(xi a) = 4 b^2 (T(xi b) - T(xi a))/x.
    """
    gamma = (1 - 2 * nu) / (2 * (1 - nu))

    def imbalance(x: float) -> float:
        p, q = half * half * (1 - gamma * x), half * half * (1 - x)
        return x * _tanh_over(p) + 4 * (1 - x) * (1 - gamma) * half * half * _slope(p, q)

    # Mindlin's frequency is a few per cent off at most; at x = 1 the wave would be as fast as shear waves.
    return float(brentq(imbalance, 0.5 * _mindlin(half, nu), 1.0, xtol=1e-300, rtol=1e-14))


def _tanh_over(z: float) -> float:
    """Return tanh(y)/y of z = y^2."""
    return math.tanh(math.sqrt(z)) / math.sqrt(z) if z > 0 else 1.0


def _slope(p: float, q: float) -> float:
    """Return (T(p) - T(q))/(p - q) of T(z) = tanh(sqrt z)/sqrt z."""
    if max(p, q) > _SERIES_BELOW**2:
        return (_tanh_over(p) - _tanh_over(q)) / (p - q)
    return sum(c * sum(p**j * q ** (n - 1 - j) for j in range(n)) for n, c in enumerate(_TANH) if n)


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
