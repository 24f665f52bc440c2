"""Modes of a plate and the inverse problems; which of the paper's numbers go together; designs and their errors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionloop.hardware.plate.modes import (
    _SERIES_BELOW,
    FREQUENCY_HZ,
    LINES,
    SHEAR,
    THICKNESS_MM,
    frequency_hz,
    mode,
    mode_of,
    nearest_mode,
    plate_readings,
    resonance_hz,
    thickness_for_mm,
    wave_number_per_m,
)
from frictionloop.parameters.plate_design import Glass, PlateDesign

GLASS = Glass()


@given(st.integers(2, 40), st.floats(50, 500), st.floats(0.3, 1.0))
def test_lines_and_thickness_are_found_from_the_frequency(lines, side_mm, thinness):
    thickness_mm = 0.9 * thinness * side_mm / (lines - 0.5)
    if thickness_mm > side_mm / 2:
        return
    found = mode(lines, side_mm, thickness_mm, GLASS)
    assert found.half_wavelength_mm * (lines - 0.5) == pytest.approx(side_mm, rel=1e-14)
    assert nearest_mode(found.frequency_hz, side_mm, thickness_mm, GLASS).nodal_lines == lines
    assert thickness_for_mm(found.frequency_hz, lines, side_mm, GLASS) == pytest.approx(thickness_mm, rel=1e-9)


@given(st.floats(1.0, 4.3e5))
def test_no_other_mode_is_nearer(frequency):
    chosen = nearest_mode(frequency, 140.0, 3.0, GLASS)
    every = [mode(n, 140.0, 3.0, GLASS).frequency_hz for n in range(2, 48)]
    assert abs(chosen.frequency_hz - frequency) == min(abs(each - frequency) for each in every)


def test_two_of_the_three_printed_numbers_hold_at_most():
    readings = plate_readings()
    assert len(readings) == 6
    assert all(len(each.agrees) <= 2 for each in readings)
    # Only 12 lines along the 140 mm keep both numbers that a ruler and a counter give.
    (fits,) = [each for each in readings if set(each.agrees) == {"thickness", "frequency"}]
    assert (fits.wave_along, fits.solved_for, fits.mode.nodal_lines) == ("width", "lines", 12)
    design = PlateDesign()
    assert mode_of(design) == fits.mode
    for each in readings:
        if each.solved_for != "lines":
            assert each.mode.nodal_lines == LINES
        if each.solved_for != "thickness":
            assert each.mode.thickness_mm == THICKNESS_MM
            assert each.mass_kg == pytest.approx(2500 * 0.255 * 0.140 * 0.003, rel=1e-14)
        if each.solved_for == "thickness":
            assert each.mode.frequency_hz == pytest.approx(FREQUENCY_HZ, rel=1e-11)


def test_a_measured_resonance_replaces_the_calculated_one():
    design = PlateDesign()
    assert resonance_hz(design) == mode_of(design).frequency_hz
    assert resonance_hz(design.evolve({"drive.resonance_hz": 46e3})) == 46e3


materials = st.builds(
    Glass,
    young_modulus_pa=st.floats(1e9, 4e11),
    poisson_ratio=st.floats(0, 0.49),
    density_kg_per_m3=st.floats(500, 2e4),
)


def shear_speed(glass):
    return math.sqrt(glass.young_modulus_pa / (2 * (1 + glass.poisson_ratio) * glass.density_kg_per_m3))


def speed_share(kh, glass, theory):
    """Phase speed over that of shear waves."""
    return 2 * math.pi * frequency_hz(kh / 3e-3, 3.0, glass, theory) / (kh / 3e-3) / shear_speed(glass)


@given(materials, st.floats(1e-6, 1e-2))
def test_a_thin_plate_is_thin_in_every_theory(glass, kh):
    bending = glass.young_modulus_pa * 3e-3**3 / (12 * (1 - glass.poisson_ratio**2))
    closed = (kh / 3e-3) ** 2 / (2 * math.pi) * math.sqrt(bending / (glass.density_kg_per_m3 * 3e-3))
    assert frequency_hz(kh / 3e-3, 3.0, glass, "thin") == pytest.approx(closed, rel=1e-14)
    for theory in ("mindlin", "lamb"):
        # The next term is -(k h)^2 (17 - 7 nu)/(120 (1 - nu)) x for the exact theory and much the same for Mindlin's;
        # (17 - 7 * 0.49)/(120 * 0.51) = 0.22.
        assert frequency_hz(kh / 3e-3, 3.0, glass, theory) == pytest.approx(closed, rel=0.25 * kh * kh + 1e-12)


@given(materials)
def test_short_waves_are_rayleigh_waves(glass):
    """c_R: x^3 - 8 x^2 + (24 - 16 g) x - 16 (1 - g) = 0 for x = (c_R/cT)^2, g = (cT/cL)^2."""
    g = (1 - 2 * glass.poisson_ratio) / (2 * (1 - glass.poisson_ratio))
    roots = np.roots([1.0, -8.0, 24 - 16 * g, -16 * (1 - g)])
    x = min(root.real for root in roots if abs(root.imag) < 1e-9 and 0 < root.real < 1)
    assert speed_share(200.0, glass, "lamb") == pytest.approx(math.sqrt(x), rel=1e-9)
    # Mindlin's short waves run at sqrt(kappa) cT, up to 1/(k h)^2 or so.
    assert speed_share(2e4, glass, "mindlin") == pytest.approx(math.sqrt(SHEAR), rel=1e-6)


@given(materials, st.floats(0.3, 6.0))
def test_the_exact_root_solves_the_equation_as_books_print_it(glass, kh):
    """tan(q d)/tan(p d) = -(q^2 - k^2)^2/(4 k^2 p q), d = h/2, p and q complex."""
    k, d = kh / 3e-3, 1.5e-3
    omega = 2 * math.pi * frequency_hz(k, 3.0, glass)
    shear, g = shear_speed(glass), (1 - 2 * glass.poisson_ratio) / (2 * (1 - glass.poisson_ratio))
    p, q = np.emath.sqrt(g * (omega / shear) ** 2 - k * k), np.emath.sqrt((omega / shear) ** 2 - k * k)
    left, right = np.tan(q * d) / np.tan(p * d), -((q * q - k * k) ** 2) / (4 * k * k * p * q)
    # The two sides cancel to 1 + O(x), x the unknown: an error of x of 1e-13 shows as 1e-13/x, x > 0.015 here.
    assert left == pytest.approx(right, rel=1e-10)


@given(materials)
def test_nothing_jumps_where_the_series_ends(glass):
    kh = 2 * _SERIES_BELOW
    below, above = (speed_share(kh * (1 + sign * 1e-9), glass, "lamb") for sign in (-1, 1))
    # c goes with kh at most; the direct form loses 12 digits at most to (kh)^4.
    assert above == pytest.approx(below, rel=1e-8)


@given(materials, st.floats(0.01, math.pi))
def test_order_of_the_theories(glass, kh):
    exact, thick, thin = (frequency_hz(kh / 3e-3, 3.0, glass, theory) for theory in ("lamb", "mindlin", "thin"))
    assert exact < thin
    assert thick < thin


@given(st.floats(1e-3, 20.0), st.floats(1.0001, 3.0))
def test_more_bending_is_faster(kh, factor):
    assert speed_share(kh * factor, GLASS, "lamb") >= speed_share(kh, GLASS, "lamb") * (1 - 1e-12)


@given(materials, st.floats(1e-3, 20.0))
def test_the_wave_number_is_found_again(glass, kh):
    k = kh / 3e-3
    assert wave_number_per_m(frequency_hz(k, 3.0, glass), 3.0, glass) == pytest.approx(k, rel=1e-9)
