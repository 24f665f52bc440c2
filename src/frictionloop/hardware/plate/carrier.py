"""The plate at the level of its carrier: pulses, band-pass, resonance, displacement, demodulated envelope.

x'' + (w0/Q) x' + w0^2 x = (w0^2/Q) a_max F(t), where F is the band-passed carrier scaled to amplitude 1 at full duty.
Time runs in ticks of the timer's clock. Pulses change only on ticks, and each pole p of band-pass and plate is stepped
by e^(p h) (the matrix exponential in diagonal form), so the displacement on the ticks has no error of integration.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from scipy.signal import lfilter

from frictionloop.hardware.plate.carrier_pwm import Analogue, band_pass, period_ticks, pulse_ticks, pulses
from frictionloop.hardware.plate.modes import resonance_hz
from frictionloop.parameters.plate_design import PlateDesign
from frictionloop.quantities import FrictionloopError

Source = Literal["pwm", "sine"]
"""Pulses of whole ticks, or an ideal modulated sine to compare with."""
_AT_ONCE = 256
"""Carrier periods computed at once: bounds the memory of long runs."""


@dataclass(frozen=True)
class CarrierRun:
    """What a run at carrier level gives, one value per carrier period."""

    time_s: np.ndarray
    """Middle of each carrier period (of its ticks)."""
    command_um: np.ndarray
    """Amplitude command in effect during it, after the drive's limits."""
    envelope_um: np.ndarray
    """Complex envelope A of the displacement Re(A e^(j 2 pi f t)), demodulated over that period."""
    carrier_hz: float
    """Carrier frequency f that the timer makes."""
    waveform_um: np.ndarray
    """Displacement on every tick of the last carrier period."""


def plate_resonator(resonance: float, quality_factor: float) -> Analogue:
    """Return (w0^2/Q)/(s^2 + s w0/Q + w0^2), of size 1 at the resonance in Hz."""
    w0 = 2 * np.pi * resonance
    poles = np.roots([1.0, w0 / quality_factor, w0 * w0])
    return Analogue(np.empty(0), poles, w0 * w0 / quality_factor)


def actual_carrier_hz(design: PlateDesign) -> float:
    """Return the carrier frequency nearest to the one wanted that the timer can make."""
    wanted = resonance_hz(design) + design.drive.detuning_hz
    return design.carrier.timer_hz / period_ticks(design.carrier.timer_hz, wanted)


def simulate_carrier(
    design: PlateDesign, command_um: np.ndarray, source: Source = "pwm", filtered: bool = True
) -> CarrierRun:
    """Return the displacement's envelope under a sequence of amplitude commands, from rest.

    Parameters
    ----------
    design : PlateDesign
        Resonance, Q, timer, band-pass. The amplifier is set so that full duty gives ``drive.max_amplitude_um`` at
        resonance.
    command_um : array (control periods,)
        Amplitude commands, one per period of ``carrier.control_hz``, limited to 0 .. a_max as by the drive. A command
        takes effect with the next carrier period, as a timer's registers do.
    source : {"pwm", "sine"}
        Pulses of whole ticks, or a sine of exactly the amplitude wanted.
    filtered : bool
        Whether the band-pass is there.

    Raises
    ------
    FrictionloopError
        For commands that are empty or not finite, another source, a clock too slow, an impossible mode.
    """
    if source not in get_args(Source):
        raise FrictionloopError(f"source = {source!r} is unknown; accepted: 'pwm', 'sine'")
    command = np.asarray(command_um, dtype=float)
    if command.ndim != 1 or not command.size or not np.all(np.isfinite(command)):
        raise FrictionloopError("command_um: must be a list of finite amplitudes in um, at least one")
    carrier_hz = actual_carrier_hz(design)
    ticks = round(design.carrier.timer_hz / carrier_hz)
    most_um = design.drive.max_amplitude_um
    periods = int(command.size / design.carrier.control_hz * carrier_hz * (1 + 1e-12))
    if not periods:
        raise FrictionloopError("command_um: lasts less than one carrier period; give more commands")
    at = (np.arange(periods) * design.carrier.control_hz / carrier_hz * (1 + 1e-12)).astype(int)
    held = np.clip(command, 0.0, most_um)[at]
    chain = _chain(design, carrier_hz, filtered)
    states = [np.zeros(1, dtype=complex) for _ in chain]
    # Envelope by correlation over one period: cycles of other harmonics, and of a constant, cancel.
    reference = 2 / ticks * np.exp(-2j * np.pi * np.arange(ticks) / ticks)
    envelope = np.empty(periods, dtype=complex)
    waveform = np.empty(0)
    for first in range(0, periods, _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        drive = _drive(held[some] / most_um, ticks, source, design.carrier.alignment)
        moved = most_um * _filtered(drive.ravel(), chain, states).reshape(-1, ticks)
        envelope[some], waveform = moved @ reference, moved[-1]
    time_s = (np.arange(periods) + 0.5 - 0.5 / ticks) / carrier_hz
    return CarrierRun(time_s, held, envelope, carrier_hz, waveform)


def _drive(share: np.ndarray, ticks: int, source: str, alignment: str) -> np.ndarray:
    """Return what the source puts out on each tick, fundamental 1 at full amplitude; a row per carrier period."""
    if source == "pwm":
        return np.pi / 2 * pulses(pulse_ticks(share, ticks), ticks, alignment)
    return -share[:, None] * np.cos(2 * np.pi * (np.arange(ticks) + 0.5) / ticks)


def _chain(design: PlateDesign, carrier_hz: float, filtered: bool) -> list[tuple[complex, complex]]:
    """Return (decay, weight) for each pole of band-pass and plate: state <- decay state + weight input, x = Re sum."""
    whole, scale = plate_resonator(resonance_hz(design), design.drive.quality_factor), 1.0
    if filtered:
        band = band_pass(design.carrier)
        whole, scale = band.then(whole), 1 / float(abs(band.response(carrier_hz)))
    steps = []
    for pole, residue in zip(whole.poles, whole.residues(), strict=True):
        if pole.imag >= 0:  # the conjugate of a complex pole counts by doubling
            decay = np.exp(pole / design.carrier.timer_hz)
            held = np.expm1(pole / design.carrier.timer_hz) / pole  # exact for an input that is constant over a tick
            steps.append((decay, (2 if pole.imag > 0 else 1) * scale * residue * held))
    return steps


def _filtered(drive: np.ndarray, chain: list[tuple[complex, complex]], states: list[np.ndarray]) -> np.ndarray:
    """Return the output on each tick and move the states on."""
    total = np.zeros_like(drive)
    for i, (decay, weight) in enumerate(chain):
        found, states[i] = lfilter([0.0, weight], [1.0, -decay], drive, zi=states[i])
        total += found.real
    return total
