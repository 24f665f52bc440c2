"""Modes of a plate and the inverse problems; which of the paper's numbers go together; designs and their errors."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionloop.hardware.plate.modes import (
    FREQUENCY_HZ,
    LINES,
    THICKNESS_MM,
    mode,
    mode_of,
    nearest_mode,
    plate_readings,
    resonance_hz,
    thickness_for_mm,
)
from frictionloop.parameters.plate_design import Glass, PlateDesign
from frictionloop.quantities import FrictionloopError

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


@pytest.mark.parametrize(
    "lines, side, thickness, said",
    [
        (1, 140.0, 3.0, r"nodal_lines = 1: must be whole, 2 to 47"),
        (48, 140.0, 3.0, r"nodal_lines = 48: must be whole, 2 to 47"),
        (12.5, 140.0, 3.0, r"nodal_lines = 12.5: must be whole"),
        (2, 140.0, 100.0, r"thickness_mm = 100 mm: must be below 93.3333$"),
        (2, 140.0, -1.0, r"thickness_mm = -1 mm: must be finite and above 0"),
        (2, math.nan, 3.0, r"side_mm = nan mm: must be finite and above 0"),
    ],
)
def test_a_mode_that_the_plate_cannot_have(lines, side, thickness, said):
    with pytest.raises(FrictionloopError, match=f"^{said}"):
        mode(lines, side, thickness, GLASS)


def test_frequencies_that_no_plate_reaches():
    with pytest.raises(FrictionloopError, match=r"^frequency_hz = 1e\+06 Hz: must be at most \d+ on this glass"):
        nearest_mode(1e6, 140.0, 3.0, GLASS)
    with pytest.raises(FrictionloopError, match=r"^frequency_hz = 1e\+06 Hz: must be at most \d+$"):
        thickness_for_mm(1e6, 12, 140.0, GLASS)
    with pytest.raises(FrictionloopError, match=r"^frequency_hz = -1 Hz: "):
        thickness_for_mm(-1, 12, 140.0, GLASS)


@pytest.mark.parametrize(
    "path, value, said",
    [
        ("drive.quality_factor", 0, "drive.quality_factor = 0: must be greater than 0.5"),
        ("drive.quality_factor", -3.0, "drive.quality_factor = -3.0: must be greater than 0.5"),
        ("geometry.nodal_lines", 1, "geometry.nodal_lines = 1: must be greater than or equal to 2"),
        ("geometry.wave_along", "height", "geometry.wave_along = 'height': must be 'length' or 'width'"),
        ("geometry.thicknes_mm", 3, "unknown parameter 'geometry.thicknes_mm'"),
        ("thickness_mm", 3, "unknown parameter 'thickness_mm'"),
        ("carrier.band_low_hz", 6e4, "carrier: band_low_hz = 60000: must be below band_high_hz = 50000"),
        ("finger.resistance_n_s_per_m", math.nan, "finger.resistance_n_s_per_m = nan"),
        ("glass.poisson_ratio", 0.5, "glass.poisson_ratio = 0.5: must be less than 0.5"),
    ],
)
def test_a_wrong_design_is_one_line(path, value, said):
    with pytest.raises(FrictionloopError) as error:
        PlateDesign().evolve({path: value})
    assert str(error.value).startswith(said)
    assert "\n" not in str(error.value)


def test_an_impossible_mode_of_a_design_is_refused_even_with_a_measured_resonance():
    design = PlateDesign().evolve({"geometry.nodal_lines": 60, "drive.resonance_hz": 46e3})
    with pytest.raises(FrictionloopError, match=r"^nodal_lines = 60: .*2 to 47"):
        resonance_hz(design)
