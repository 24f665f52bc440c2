"""What a builder wants to know about an ultrasonic plate, and what to change for a wanted frequency or bandwidth."""

from __future__ import annotations

import math
from dataclasses import dataclass

from frictionloop.hardware.plate import carrier_pwm
from frictionloop.hardware.plate import envelope as plate_envelope
from frictionloop.hardware.plate.carrier import actual_carrier_hz
from frictionloop.hardware.plate.carrier_pwm import band_pass
from frictionloop.hardware.plate.drive import Effort, FingerEffect, effort, finger_effect, modal_damping_n_s_per_m
from frictionloop.hardware.plate.envelope import quality_for_bandwidth
from frictionloop.hardware.plate.modes import PlateMode, mode_of, nearest_mode, resonance_hz, thickness_for_mm
from frictionloop.parameters.plate_design import PlateDesign


@dataclass(frozen=True)
class Vibration:
    """Mode and envelope."""

    mode: PlateMode
    """The mode by the exact theory."""
    mindlin_hz: float
    """Its frequency by thick-plate theory."""
    thin_hz: float
    """Its frequency by thin-plate theory."""
    resonance_hz: float
    """The resonance used: the measured one if the design has it, else the mode's."""
    time_constant_s: float
    """T of the envelope."""
    bandwidth_hz: float
    """f0/(2Q): the ``plate.cutoff_hz`` of a System."""


@dataclass(frozen=True)
class Electronics:
    """What timer and band-pass make of the carrier."""

    ticks: int
    """Clock ticks per carrier period."""
    carrier_hz: float
    """Carrier frequency that the timer makes."""
    detuning_hz: float
    """Carrier less resonance."""
    detuned_gain: float
    """Amplitude over that of a tuned drive."""
    levels: int
    """Amplitudes above zero that the pulse widths give."""
    largest_step_um: float
    """Distance of the amplitudes nearest to zero, the largest; at share s of full amplitude sqrt(1 - s^2) of it."""
    filter_delay_s: float
    """Group delay of the band-pass at the carrier."""
    filter_gain: float
    """Gain of the band-pass at the carrier, 1 in its middle."""
    second_harmonic: float
    """Gain of the band-pass at twice the carrier over that at the carrier."""
    longest_wait_s: float
    """A command waits at most one carrier period for the timer."""


@dataclass(frozen=True)
class PlateAnswers:
    """Everything about one design."""

    vibration: Vibration
    """Mode and envelope."""
    effort: Effort
    """What full amplitude takes."""
    finger: FingerEffect
    """What a finger changes."""
    electronics: Electronics
    """What the carrier adds."""


def plate_answers(design: PlateDesign) -> PlateAnswers:
    """Return mode, envelope, drive, finger and carrier of a design.

    Raises
    ------
    FrictionloopError
        For a mode that the plate cannot have, or a timer too slow for the carrier.
    """
    vibration = _vibration(design)
    electronics, resonance = _electronics(design, vibration.resonance_hz), vibration.resonance_hz
    half_mm = vibration.mode.half_wavelength_mm
    return PlateAnswers(
        vibration,
        effort(design, resonance, half_mm, electronics.detuned_gain),
        finger_effect(design, modal_damping_n_s_per_m(design, resonance), half_mm),
        electronics,
    )


def _vibration(design: PlateDesign) -> Vibration:
    resonance, quality = resonance_hz(design), design.drive.quality_factor
    return Vibration(
        mode=mode_of(design),
        mindlin_hz=mode_of(design, "mindlin").frequency_hz,
        thin_hz=mode_of(design, "thin").frequency_hz,
        resonance_hz=resonance,
        time_constant_s=plate_envelope.time_constant_s(resonance, quality),
        bandwidth_hz=plate_envelope.bandwidth_hz(resonance, quality),
    )


def _electronics(design: PlateDesign, resonance: float) -> Electronics:
    carrier_hz, band = actual_carrier_hz(design), band_pass(design.carrier)
    ticks = round(design.carrier.timer_hz / carrier_hz)
    gain = float(abs(band.response(carrier_hz)))
    return Electronics(
        ticks=ticks,
        carrier_hz=carrier_hz,
        detuning_hz=carrier_hz - resonance,
        detuned_gain=plate_envelope.detuned_gain(resonance, design.drive.quality_factor, carrier_hz - resonance),
        levels=ticks // 2,
        largest_step_um=design.drive.max_amplitude_um * carrier_pwm.amplitude_step(0.0, ticks),
        filter_delay_s=float(band.group_delay_s(carrier_hz)),
        filter_gain=gain,
        second_harmonic=float(abs(band.response(2 * carrier_hz))) / gain,
        longest_wait_s=1 / carrier_hz,
    )


@dataclass(frozen=True)
class Wanted:
    """What would give a frequency or a bandwidth; NaN or None where nothing was asked."""

    nearest: PlateMode | None
    """Mode of this plate nearest to the frequency."""
    thickness_mm: float
    """Thickness at which the design's number of lines has the frequency."""
    quality_factor: float
    """Q that gives the bandwidth, at the frequency if one is asked for, else at the design's resonance."""


def plate_for(design: PlateDesign, frequency_hz: float | None = None, bandwidth_hz: float | None = None) -> Wanted:
    """Return which mode, thickness and Q give a wanted frequency and envelope bandwidth.

    Parameters
    ----------
    design : PlateDesign
        Glass, size and mode to start from.
    frequency_hz, bandwidth_hz : float, optional
        What is wanted, positive.

    Raises
    ------
    FrictionloopError
        For a frequency or a bandwidth that no mode, thickness or Q gives.
    """
    side_mm, thickness_mm = design.geometry.side_mm, design.geometry.thickness_mm
    nearest, needed_mm, quality = None, math.nan, math.nan
    if frequency_hz is not None:
        nearest = nearest_mode(frequency_hz, side_mm, thickness_mm, design.glass)
        needed_mm = thickness_for_mm(frequency_hz, design.geometry.nodal_lines, side_mm, design.glass)
    if bandwidth_hz is not None:
        carrier = resonance_hz(design) if frequency_hz is None else frequency_hz
        quality = quality_for_bandwidth(carrier, bandwidth_hz)
    return Wanted(nearest, needed_mm, quality)
