"""What a builder wants to know about an ultrasonic plate, and what to change for a wanted frequency or bandwidth."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from frictionloop.findings import Finding, Result, shown
from frictionloop.findings.result import Row, Tables, frame, toml_table
from frictionloop.hardware.plate import carrier_simulation as plate_carrier
from frictionloop.hardware.plate import drive_requirements as plate_drive
from frictionloop.hardware.plate.carrier_simulation import EnvelopeCheck, actual_carrier_hz, band_pass, check_envelope
from frictionloop.hardware.plate.drive_requirements import (
    Effort,
    FingerEffect,
    bare,
    effort,
    finger_effect,
    modal_damping_n_s_per_m,
    quality_for_bandwidth,
)
from frictionloop.hardware.plate.modes import (
    PlateMode,
    PlateReading,
    mode_of,
    nearest_mode,
    plate_readings,
    resonance_hz,
    thickness_for_mm,
)
from frictionloop.parameters.doubtful_values import unusual
from frictionloop.parameters.plate_design import PlateDesign

PASSED, TUNED = 0.5, 0.9
"""Gain of the band-pass, and share of the amplitude of a tuned drive, below which either is told (assumed)."""


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
    """T of the envelope, without a finger."""
    bandwidth_hz: float
    """f0/(2Q) without a finger: the ``plate.cutoff_hz`` of a System that nobody touches."""


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
class Wanted:
    """What would give a frequency or a bandwidth; NaN or None where nothing was asked."""

    nearest: PlateMode | None
    """Mode of this plate nearest to the frequency."""
    thickness_mm: float
    """Thickness at which the design's number of lines has the frequency."""
    quality_factor: float
    """Q that gives the bandwidth, at the frequency if one is asked for, else at the design's resonance."""
    frequency_hz: float | None = None
    """As asked for."""
    bandwidth_hz: float | None = None


class PlateAnswers(Result, schema="design.plate/1"):
    """Everything about one design."""

    design: PlateDesign
    """Its Q and amplitude are those without a finger."""
    vibration: Vibration
    """Mode and envelope."""
    effort: Effort
    """What full amplitude takes."""
    finger: FingerEffect
    """What a finger changes."""
    electronics: Electronics
    """What the carrier adds."""
    plate: Mapping[str, Any]
    """The block of a System, with a finger on the plate."""
    wanted: Wanted
    readings: tuple[PlateReading, ...] = ()
    carrier: tuple[EnvelopeCheck, ...] = ()

    def rows(self) -> list[Row]:
        """Return mode, envelope, drive and carrier, and what would give what was asked for."""
        mode, drive, wired, touched = self.vibration.mode, self.design.drive, self.electronics, self.finger
        return [
            (
                "mode",
                f"{_khz(mode.frequency_hz)}, {mode.nodal_lines} lines {shown(mode.half_wavelength_mm, 4)} mm apart",
            ),
            ("envelope", f"{shown(self.vibration.bandwidth_hz, 4)} Hz, Q {shown(drive.quality_factor)}"),
            (
                "touched",
                f"{100.0 * touched.amplitude_on_touch:.0f} % of the amplitude, Q {shown(touched.quality_on_touch)}; "
                f"a stroke feels {100.0 * touched.felt_ripple:.0f} % ripple",
            ),
            (
                "drive",
                f"{shown(self.effort.voltage_v)} V, {shown(self.effort.force_n)} N, {shown(self.effort.power_w)} W "
                f"for {shown(drive.max_amplitude_um)} um",
            ),
            (
                "carrier",
                f"{_khz(wired.carrier_hz)}, {wired.levels} levels, amplitude {100.0 * wired.detuned_gain:.1f} %, "
                f"{shown(1e6 * wired.filter_delay_s)} us",
            ),
            *self._wanted(),
        ]

    def _wanted(self) -> Iterator[Row]:
        wanted, said = self.wanted, []
        if wanted.frequency_hz is not None:
            said.append(f"{_khz(wanted.frequency_hz)} with {shown(wanted.thickness_mm, 4)} mm")
        if wanted.bandwidth_hz is not None:
            said.append(f"{shown(wanted.bandwidth_hz, 4)} Hz with Q {shown(wanted.quality_factor)}")
        if said:
            yield "wanted", "; ".join(said)

    def tables(self) -> Tables:
        """Return readings of the paper and errors of the envelope if they were asked for, the block, all figures."""
        import pandas as pd  # type: ignore[import-untyped]

        found = {}
        if self.readings:
            found["the paper's plate"] = frame([_read(each) for each in self.readings], "wave along")
        if self.carrier:
            found["off the first-order envelope, %"] = frame([_error(each) for each in self.carrier], "drive")
        parts = {name: asdict(getattr(self, name)) for name in ("vibration", "effort", "finger", "electronics")}
        flat = {f"{part}.{key}": value for part, values in parts.items() for key, value in values.items()}
        mode = {f"mode.{key}": value for key, value in flat.pop("vibration.mode").items()}
        figures = pd.DataFrame({"value": {**mode, **flat}}, dtype=object).rename_axis("figure")
        return {**found, "block": toml_table("plate", self.plate), "figures": figures}


def plate(
    design: PlateDesign | None = None,
    overrides: Mapping[str, Any] | None = None,
    *,
    frequency_hz: float | None = None,
    bandwidth_hz: float | None = None,
    check_carrier: bool = False,
    readings: bool = False,
) -> PlateAnswers:
    """Return mode, envelope, drive, finger and carrier of a plate, and the block of it for a System.

    Parameters
    ----------
    design
        Glass, size, mode, drive, finger and carrier; None: as built in.
    overrides
        Values of it by dotted name: ``{"geometry.thickness_mm": 4.0, "drive.finger_on": True}``.
    frequency_hz
        Resonance wanted: which mode, which thickness. All else is of that mode, unless ``overrides`` name another.
    bandwidth_hz
        Bandwidth of the envelope wanted, without a finger: which Q.
    check_carrier
        Simulate the carrier too, and compare it with the first-order envelope.
    readings
        Tell which of the paper's numbers go together too.

    Raises
    ------
    FrictionloopError
        For a mode that the plate cannot have, a timer too slow for the carrier, a Q that no plate has with that
        finger on it, or a frequency or bandwidth that no mode, thickness or Q gives.
    """
    own = dict(overrides or {})
    described = (design or PlateDesign()).evolve(own)
    if frequency_hz is not None and "geometry.nodal_lines" not in own:
        nearest = plate_for(described, frequency_hz).nearest
        described = described.evolve({"geometry.nodal_lines": nearest.nodal_lines if nearest else 2})
    there = bare(described, resonance_hz(described))
    vibration = _vibration(there)
    half_mm, wired = vibration.mode.half_wavelength_mm, _electronics(there, vibration.resonance_hz)
    finger = finger_effect(there, modal_damping_n_s_per_m(there, vibration.resonance_hz), half_mm)
    return PlateAnswers(
        design=there,
        vibration=vibration,
        effort=effort(there, vibration.resonance_hz, half_mm, wired.detuned_gain),
        finger=finger,
        electronics=wired,
        plate={
            "kind": "resonant",
            "frequency_hz": vibration.resonance_hz,
            "q": finger.quality_on_touch,
            "max_amplitude_um": finger.amplitude_on_touch * there.drive.max_amplitude_um,
        },
        wanted=plate_for(described, frequency_hz, bandwidth_hz),
        readings=plate_readings(there.glass) if readings else (),
        carrier=(check_envelope(there, "sine", False), check_envelope(there)) if check_carrier else (),
        findings=(*unusual(described), *_doubts(there, wired)),
    )


def _doubts(design: PlateDesign, wired: Electronics) -> Iterator[Finding]:
    carrier = design.carrier
    if wired.filter_gain < PASSED:
        ends = {"low": 1e-3 * carrier.band_low_hz, "high": 1e-3 * carrier.band_high_hz}
        yield Finding("CARRIER-BAND", value=1e-3 * wired.carrier_hz, unit="kHz", limit=wired.filter_gain, more=ends)
    if wired.detuned_gain < TUNED:
        yield Finding("CARRIER-OFF", value=wired.detuning_hz, unit="Hz", limit=100.0 * wired.detuned_gain)


def _vibration(design: PlateDesign) -> Vibration:
    resonance, quality = resonance_hz(design), design.drive.quality_factor
    return Vibration(
        mode=mode_of(design),
        mindlin_hz=mode_of(design, "mindlin").frequency_hz,
        thin_hz=mode_of(design, "thin").frequency_hz,
        resonance_hz=resonance,
        time_constant_s=plate_drive.time_constant_s(resonance, quality),
        bandwidth_hz=plate_drive.bandwidth_hz(resonance, quality),
    )


def _electronics(design: PlateDesign, resonance: float) -> Electronics:
    carrier_hz, band = actual_carrier_hz(design), band_pass(design.carrier)
    ticks = round(design.carrier.timer_hz / carrier_hz)
    gain = float(abs(band.response(carrier_hz)))
    return Electronics(
        ticks=ticks,
        carrier_hz=carrier_hz,
        detuning_hz=carrier_hz - resonance,
        detuned_gain=plate_drive.detuned_gain(resonance, design.drive.quality_factor, carrier_hz - resonance),
        levels=ticks // 2,
        largest_step_um=design.drive.max_amplitude_um * plate_carrier.amplitude_step(0.0, ticks),
        filter_delay_s=float(band.group_delay_s(carrier_hz)),
        filter_gain=gain,
        second_harmonic=float(abs(band.response(2 * carrier_hz))) / gain,
        longest_wait_s=1 / carrier_hz,
    )


def plate_for(design: PlateDesign, frequency_hz: float | None = None, bandwidth_hz: float | None = None) -> Wanted:
    """Return which mode, thickness and Q give a wanted frequency and envelope bandwidth.

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
    return Wanted(nearest, needed_mm, quality, frequency_hz, bandwidth_hz)


def _read(each: PlateReading) -> dict[str, Any]:
    mode = each.mode
    return {
        "wave along": each.wave_along,
        "lines": mode.nodal_lines,
        "thickness, mm": mode.thickness_mm,
        "kHz": 1e-3 * mode.frequency_hz,
        "glass, g": 1e3 * each.mass_kg,
        "as printed": ", ".join(each.agrees),
    }


def _error(each: EnvelopeCheck) -> dict[str, Any]:
    shares = {"largest": each.largest, "theory allows": each.allowed, "without the delay": each.undelayed}
    drive = each.source + " + band-pass" * each.filtered
    return {"drive": drive} | {name: 100.0 * share for name, share in shares.items()}


def _khz(frequency_hz: float) -> str:
    return f"{frequency_hz / 1e3:.2f} kHz"
