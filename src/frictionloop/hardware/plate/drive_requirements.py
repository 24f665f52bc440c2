"""Drive of the plate's mode: how much a voltage moves it, what a finger takes, and how fast its envelope follows.

The plate moves as w = a cos(k x) cos(omega t); over whole half waves cos^2 averages to 1/2. Rotation of the cross
sections, which adds (k h)^2/12 (5 % at 46 kHz and 3 mm) to the kinetic energy of a thin plate, is left out.

What a finger does to the vibration: it damps the mode, more on an antinode than on a nodal line.

A contact at x takes from the mode as its resistance times F(x), the mean of cos^2(k x) over the contact:
F = (1 + s cos 2kx)/2, s = 2 J1(k d)/(k d) for a round contact of diameter d. F has the period of half a wavelength.

The plate's displacement is the real part of A(t) e^(j 2 pi f t), f the carrier. Its complex envelope A obeys (Q >> 1)

    dA/dt = -(1/T - j 2 pi df) A + c/T,    T = 2Q/omega0 = Q/(pi f0),  df = f0 - f,

c being the amplitude that the same drive reaches at resonance. The error of this is of the order 1/(2Q).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter
from scipy.special import j1

from frictionloop.parameters.plate_design import Glass, Piezo, PlateDesign, PlateGeometry
from frictionloop.quantities import must_be
from frictionloop.quantities.value_checks import ABOVE_0, number


def time_constant_s(resonance_hz: float, quality_factor: float) -> float:
    """Return T = Q/(pi f0), the time in which a free vibration falls to 1/e."""
    return quality_factor / (math.pi * resonance_hz)


def bandwidth_hz(resonance_hz: float, quality_factor: float) -> float:
    """Return the cutoff f0/(2Q) of the first-order envelope, what ``plate.cutoff_hz`` of a System is."""
    return 1.0 / (2.0 * math.pi * time_constant_s(resonance_hz, quality_factor))


def quality_for_bandwidth(resonance_hz: float, bandwidth: float) -> float:
    """Return the Q = f0/(2B) that gives an envelope bandwidth B in Hz.

    Raises
    ------
    FrictionloopError
        For a bandwidth that is not between 0 and f0, where Q would be 1/2.
    """
    number("bandwidth_hz", bandwidth, "Hz", ABOVE_0)
    if bandwidth >= resonance_hz:
        raise must_be("bandwidth_hz", bandwidth, f"below the resonance, {resonance_hz:g}", "Hz")
    return resonance_hz / (2.0 * bandwidth)


def envelope_pole(resonance_hz: float, quality_factor: float, detuning_hz: float = 0.0) -> complex:
    """Return the pole -1/T + j 2 pi df of the complex envelope in rad/s; the amplitude has it and its conjugate.

    The detuning is the carrier less the resonance, -df.
    """
    return complex(-1.0 / time_constant_s(resonance_hz, quality_factor), -2.0 * math.pi * detuning_hz)


def detuned_gain(resonance_hz: float, quality_factor: float, detuning_hz: float) -> float:
    """Return the steady amplitude of a detuned drive over that at resonance, 1/sqrt(1 + (2 pi df T)^2)."""
    pole = envelope_pole(resonance_hz, quality_factor, detuning_hz)
    return -pole.real / abs(pole)


def envelope(command: np.ndarray, step_s: float, pole: complex, start: complex = 0.0) -> np.ndarray:
    """Return the complex envelope at the start of every step and after the last one, exact for held commands.

    Commands are complex if the phase of the carrier moves with them.
    """
    held = np.append(np.asarray(command, dtype=complex), 0.0)
    target = held * (pole.real / pole)  # what A settles on: c/(1 - j 2 pi df T)
    decay = np.exp(pole * step_s)
    # a[k+1] = decay a[k] + (1 - decay) target[k]
    found, _ = lfilter([0.0, 1.0 - decay], [1.0, -decay], target, zi=np.array([start + 0j]))
    return np.asarray(found)


@dataclass(frozen=True)
class Effort:
    """What full amplitude takes."""

    plate_mass_kg: float
    """Mass of the glass."""
    modal_mass_kg: float
    """M, half of it: the mass at an antinode that has the kinetic energy of the mode."""
    kinetic_energy_j: float
    """Largest kinetic energy, M (omega a)^2/2."""
    power_w: float
    """Power lost in the plate, without a finger: omega/Q of the energy."""
    force_n: float
    """Force on an antinode at resonance, zero-to-peak: M omega^2 a/Q."""
    force_n_per_v: float
    """Force of all patches per volt."""
    voltage_v: float
    """Voltage for full amplitude at the actual carrier, zero-to-peak, without a finger."""


def effort(design: PlateDesign, resonance_hz: float, half_wavelength_mm: float, detuned_gain: float) -> Effort:
    """Return what full amplitude takes at a resonance in Hz, driven with this share of the amplitude of a tuned drive.

    A resonance loses what a damping of M omega/Q takes from the speed of its antinodes (a definition of Q).
    """
    glass_kg = plate_mass_kg(design.geometry, design.glass)
    speed_m_s = 2 * math.pi * resonance_hz * design.drive.max_amplitude_um * 1e-6
    damping = modal_damping_n_s_per_m(design, resonance_hz)
    per_v = piezo_force_n_per_v(design.piezo, design.geometry.thickness_mm, half_wavelength_mm)
    return Effort(
        plate_mass_kg=glass_kg,
        modal_mass_kg=glass_kg / 2,
        kinetic_energy_j=glass_kg / 2 * speed_m_s**2 / 2,
        power_w=damping * speed_m_s**2 / 2,
        force_n=damping * speed_m_s,
        force_n_per_v=per_v,
        voltage_v=damping * speed_m_s / per_v / detuned_gain,
    )


def plate_mass_kg(geometry: PlateGeometry, glass: Glass) -> float:
    """Return the mass of the glass, rho L W h."""
    return glass.density_kg_per_m3 * geometry.length_mm * geometry.width_mm * geometry.thickness_mm * 1e-9


def modal_damping_n_s_per_m(design: PlateDesign, resonance_hz: float) -> float:
    """Return the plate's own damping M omega/Q in N s/m at an antinode."""
    modal_kg = plate_mass_kg(design.geometry, design.glass) / 2
    return modal_kg * 2 * math.pi * resonance_hz / design.drive.quality_factor


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
    lever_m = (thickness_mm + piezo.patch_thickness_mm) * 1e-3
    k = math.pi / (half_wavelength_mm * 1e-3)
    return piezo.patches * piezo.e31_n_per_vm * piezo.patch_width_mm * 1e-3 * lever_m * k


@dataclass(frozen=True)
class FingerEffect:
    """A finger anywhere on the plate."""

    amplitude_on_touch: float
    """Amplitude of the antinodes over that without a finger, at the mean F = 1/2."""
    quality_on_touch: float
    """Q at that place."""
    plate_ripple: float
    """Amplitude of the antinodes along a stroke, (max - min)/(max + min)."""
    felt_ripple: float
    """Rms amplitude under the contact along a stroke, likewise: what the finger's friction follows."""


def mode_factor(position_mm: np.ndarray | float, half_wavelength_mm: float, contact_mm: float) -> np.ndarray:
    """Return F, the mean of cos^2(k x) under a round contact, whose centre is so far from an antinode."""
    k = math.pi / half_wavelength_mm
    spread = 2 * j1(k * contact_mm) / (k * contact_mm)
    return np.asarray((1 + spread * np.cos(2 * k * np.asarray(position_mm))) / 2)


def amplitude_left(factor: np.ndarray | float, plate_n_s_per_m: float, finger_n_s_per_m: float) -> np.ndarray:
    """Return R_p/(R_p + F R_f): amplitude of the antinodes with a finger over that without, drive unchanged.

    R_p = M omega/Q is the plate's own damping.
    """
    return np.asarray(plate_n_s_per_m / (plate_n_s_per_m + np.asarray(factor) * finger_n_s_per_m))


def bare(design: PlateDesign, resonance_hz: float) -> PlateDesign:
    """Return a design whose Q and amplitude are those without a finger: 1/Q = 1/Q_on - R_f/(2 M omega).

    Raises
    ------
    FrictionloopError
        For a Q with the finger on that this finger alone would lower further.
    """
    if not design.drive.finger_on:
        return design
    quality, on_n_s_per_m = design.drive.quality_factor, modal_damping_n_s_per_m(design, resonance_hz)
    plate_n_s_per_m = on_n_s_per_m - design.finger.resistance_n_s_per_m / 2
    if plate_n_s_per_m <= 0.0:
        most = 2 * on_n_s_per_m * quality / design.finger.resistance_n_s_per_m
        raise must_be("drive.quality_factor", quality, f"below {most:.4g}, or finger.resistance_n_s_per_m smaller")
    left = plate_n_s_per_m / on_n_s_per_m
    values = {"finger_on": False, "quality_factor": quality / left}
    values["max_amplitude_um"] = design.drive.max_amplitude_um / left
    return design.evolve({f"drive.{name}": value for name, value in values.items()})


def finger_effect(design: PlateDesign, plate_n_s_per_m: float, half_wavelength_mm: float) -> FingerEffect:
    """Return what the finger of a design changes; the other arguments as in ``amplitude_left`` and ``mode_factor``."""
    finger, quality = design.finger, design.drive.quality_factor
    mean = float(amplitude_left(0.5, plate_n_s_per_m, finger.resistance_n_s_per_m))
    along_mm = np.linspace(0.0, half_wavelength_mm, 721)
    factor = mode_factor(along_mm, half_wavelength_mm, finger.contact_mm)
    plate = amplitude_left(factor, plate_n_s_per_m, finger.resistance_n_s_per_m)
    return FingerEffect(mean, quality * mean, _ripple(plate), _ripple(plate * np.sqrt(factor)))


def _ripple(values: np.ndarray) -> float:
    return float((values.max() - values.min()) / (values.max() + values.min()))
