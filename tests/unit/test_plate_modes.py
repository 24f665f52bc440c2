"""Modes of a plate and the inverse problems; which of the paper's numbers go together; designs and their errors."""

from __future__ import annotations

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
