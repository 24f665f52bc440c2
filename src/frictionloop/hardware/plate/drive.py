"""What it takes to vibrate the plate: mass, energy, power, force, and the piezo voltage that gives it.

The plate moves as w = a cos(k x) cos(omega t); over whole half waves cos^2 averages to 1/2. Rotation of the cross
sections, which adds (k h)^2/12 (5 % at 46 kHz and 3 mm) to the kinetic energy of a thin plate, is left out.
"""

from __future__ import annotations

import math

from frictionloop.hardware.plate.checks import check_positive, check_quality
from frictionloop.parameters.plate_design import Glass, Piezo, PlateGeometry


def plate_mass_kg(geometry: PlateGeometry, glass: Glass) -> float:
    """Return the mass of the glass, rho L W h."""
    return glass.density_kg_per_m3 * geometry.length_mm * geometry.width_mm * geometry.thickness_mm * 1e-9


def modal_mass_kg(geometry: PlateGeometry, glass: Glass) -> float:
    """Return M = m/2, the mass at an antinode that has the kinetic energy of the mode."""
    return plate_mass_kg(geometry, glass) / 2


def kinetic_energy_j(modal_mass: float, resonance_hz: float, amplitude_um: float) -> float:
    """Return the largest kinetic energy M (omega a)^2/2 in J of a modal mass in kg, a zero-to-peak."""
    check_positive(modal_mass_kg=modal_mass, resonance_hz=resonance_hz, amplitude_um=amplitude_um)
    return modal_mass * (2 * math.pi * resonance_hz * amplitude_um * 1e-6) ** 2 / 2


def drive_power_w(kinetic_energy: float, resonance_hz: float, quality_factor: float) -> float:
    """Return the power P = omega KE/Q in W that keeps an energy in J (a definition of Q)."""
    check_positive(kinetic_energy_j=kinetic_energy, resonance_hz=resonance_hz)
    check_quality(quality_factor)
    return 2 * math.pi * resonance_hz * kinetic_energy / quality_factor


def modal_force_n(modal_mass: float, resonance_hz: float, amplitude_um: float, quality_factor: float) -> float:
    """Return the force M omega^2 a/Q in N, zero-to-peak, that an antinode needs at resonance."""
    check_positive(modal_mass_kg=modal_mass, resonance_hz=resonance_hz, amplitude_um=amplitude_um)
    check_quality(quality_factor)
    return modal_mass * (2 * math.pi * resonance_hz) ** 2 * amplitude_um * 1e-6 / quality_factor


def modal_damping_n_s_per_m(modal_mass: float, resonance_hz: float, quality_factor: float) -> float:
    """Return the plate's own damping M omega/Q in N s/m at an antinode."""
    check_positive(modal_mass_kg=modal_mass, resonance_hz=resonance_hz)
    check_quality(quality_factor)
    return modal_mass * 2 * math.pi * resonance_hz / quality_factor


def piezo_force_n_per_v(piezo: Piezo, thickness_mm: float, half_wavelength_mm: float) -> float:
    """Return the modal force of all patches per volt, n e31 b (h + hp) k.

    A field V/hp stresses a patch by e31 V/hp, so each mm of its width b bends the plate by the moment
    e31 V (h + hp)/2; the mode's curvature k^2 cos(k x) integrates to 2 k over the half wave that the patch covers.
    The patch's own stiffness and mass and the shift of the neutral line are left out.

    Parameters
    ----------
    piezo : Piezo
        n patches of e31 in N/(V m), width b and thickness hp, each half a wavelength long.
    thickness_mm, half_wavelength_mm : float
        h and pi/k.
    """
    check_positive(thickness_mm=thickness_mm, half_wavelength_mm=half_wavelength_mm)
    lever_m = (thickness_mm + piezo.patch_thickness_mm) * 1e-3
    k = math.pi / (half_wavelength_mm * 1e-3)
    return piezo.patches * piezo.e31_n_per_vm * piezo.patch_width_mm * 1e-3 * lever_m * k
