"""Mass, energy, power, force and voltage, from the fields of the mode by numerical integration."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionloop.hardware.plate.drive_requirements import effort, modal_damping_n_s_per_m, piezo_force_n_per_v
from frictionloop.parameters.plate_design import Piezo, PlateDesign

HALF_MM = 140 / 11.5


def plate(amplitude=2.5, quality=230.0, **piezo):
    """Return a design and what it takes at 46 kHz, at a carrier that is tuned."""
    tree = {"drive.max_amplitude_um": amplitude, "drive.quality_factor": quality}
    design = PlateDesign().evolve(tree | {f"piezo.{name}": value for name, value in piezo.items()})
    return design, effort(design, 46e3, HALF_MM, 1.0)


@given(st.integers(2, 40), st.floats(0.1, 5.0))
def test_energy_is_that_of_the_moving_glass(lines, amplitude):
    """Half of rho h v^2 over the plate; cos^2(kx) between edges that are antinodes of k = n pi/L."""
    k = (lines - 1) * math.pi / 0.140
    x = (np.arange(4000) + 0.5) / 4000 * 0.140
    speed = 2 * math.pi * 46e3 * amplitude * 1e-6 * np.cos(k * x)
    direct = np.mean(2500 * 0.003 * 0.255 * 0.140 * speed**2) / 2
    assert plate(amplitude)[1].kinetic_energy_j == pytest.approx(direct, rel=1e-10)


def test_a_standing_wave_that_ends_between_nodes_changes_little():
    """With k = (2N - 1) pi/(2L) the mean of cos^2 about the middle is 1/2 to within 1/(2 k L) = 1/((2N - 1) pi)."""
    for lines in range(2, 40):
        k_l = (2 * lines - 1) * math.pi / 2
        mean = 0.5 + (-1) ** lines * math.sin(k_l) / (2 * k_l)
        assert abs(mean - 0.5) <= 1 / ((2 * lines - 1) * math.pi) + 1e-12


def test_figures_of_the_research_notes():
    """Notes C.5 and C.6, to the digits given there."""
    design, found = plate(patches=1)
    assert found.plate_mass_kg == pytest.approx(0.268, abs=5e-4)
    assert 2 * math.pi * 46e3 * 2.5e-6 == pytest.approx(0.72, abs=5e-3)
    assert found.kinetic_energy_j == pytest.approx(35e-3, abs=5e-4)
    assert found.power_w == pytest.approx(44, abs=0.5)
    assert plate(1.25)[1].power_w == pytest.approx(11, abs=0.5)
    assert found.force_n == pytest.approx(122, abs=0.5)
    assert modal_damping_n_s_per_m(design, 46e3) == pytest.approx(168, abs=0.5)
    assert found.force_n_per_v == pytest.approx(0.19, abs=5e-3)
    assert found.voltage_v / 4 == pytest.approx(160, abs=5)
    assert found.voltage_v / 4 * 14 / 20 == pytest.approx(110, abs=5)


@given(st.floats(5, 2000), st.floats(1e4, 1e5), st.floats(0.1, 5.0))
def test_power_and_force_by_their_definitions(q, f0, amplitude):
    """P = omega E/Q, and F = M omega^2 a/Q, whose mean work is that power."""
    design, omega = plate(amplitude, q)[0], 2 * math.pi * f0
    found = effort(design, f0, HALF_MM, 0.5)
    assert found.power_w == pytest.approx(omega * found.kinetic_energy_j / q, rel=1e-12)
    assert found.force_n == pytest.approx(found.modal_mass_kg * omega**2 * amplitude * 1e-6 / q, rel=1e-12)
    assert found.power_w == pytest.approx(found.force_n * omega * amplitude * 1e-6 / 2, rel=1e-12)
    assert found.voltage_v * found.force_n_per_v == pytest.approx(2 * found.force_n, rel=1e-12)


def test_power_of_a_ring_down():
    """What x'' + w/Q x' + w^2 x = 0 loses in its first period, in the limit of high Q."""
    q, found = 1e5, plate(quality=1e5)[1]
    left = math.exp(-2 * math.pi / q)  # of the energy after one period
    assert found.power_w == pytest.approx(found.kinetic_energy_j * (1 - left) * 46e3, rel=2 * math.pi / q)


@given(st.floats(0.3, 6), st.floats(3, 30), st.floats(0.1, 1))
def test_the_patch_does_the_work_of_its_moment_on_the_curvature(thickness, half_mm, patch_mm):
    """Virtual work over one patch: e31 V (h + hp)/2 times the curvature k^2 cos(kx), over a half wave and the width."""
    piezo = Piezo(patches=3, patch_width_mm=17.0, patch_thickness_mm=patch_mm)
    k = math.pi / (half_mm * 1e-3)
    x = ((np.arange(2000) + 0.5) / 2000 - 0.5) * half_mm * 1e-3
    work = np.mean(15.0 * (thickness + patch_mm) * 1e-3 / 2 * k * k * np.cos(k * x)) * half_mm * 1e-3 * 17e-3 * 3
    # The midpoint rule over half a cosine errs by (pi/2000)^2/24 = 1e-7.
    assert piezo_force_n_per_v(piezo, thickness, half_mm) == pytest.approx(work, rel=2e-7)
