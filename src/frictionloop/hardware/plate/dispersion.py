"""Frequency of bending waves in glass over their wave number: thin plate, Mindlin, exact (Rayleigh-Lamb, A0).

Symbols: k wave number, h thickness, E, nu, rho, G = E/(2(1 + nu)), D = E h^3/(12(1 - nu^2)), cT^2 = G/rho,
gamma = (cT/cL)^2 = (1 - 2 nu)/(2(1 - nu)), xi = k h/2 and x = (omega/(k cT))^2. Plane strain throughout: the wave
runs in one direction and is uniform in the other.
"""

from __future__ import annotations

import math
from typing import Literal, get_args

from scipy.optimize import brentq

from frictionloop.parameters.plate_design import Glass
from frictionloop.quantities import FrictionloopError

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
