"""The plate at the level of its carrier, and how far the first-order envelope that the loop uses is from it.

x'' + (w0/Q) x' + w0^2 x = (w0^2/Q) a_max F(t), where F is the band-passed carrier scaled to amplitude 1 at full duty.
Time runs in ticks of the timer's clock. Pulses change only on ticks, and each pole p of band-pass and plate is stepped
by e^(p h) (the matrix exponential in diagonal form), so the displacement on the ticks has no error of integration.

The check simulates a step of the amplitude to a_max and one down to a part of it. Beside them stands da/dt = (c - a)/T,
delayed by the band-pass. Per unit of the step, theory allows

- 1/Q: the plate also answers the part that turns the other way, 1/(2Q), which demodulation turns into 1/(4Q) more;
- for pulses (pi/4 + 3/4)/Q: switching their constant and harmonic parts on and off rings the plate, as a force at n f
  moves it by 1/(Q (n^2 - 1)) of one at f, and n times that in velocity; and pi/(2C): half a tick of pulse width;
- for the band-pass (1/T) times the integral of |s(t) - H(t - delay)|, s its envelope's step response.

Left out is the band-pass's own brief answer to the constant and harmonic parts of the pulses, which it rejects; so with
pulses and band-pass together the sum is an estimate from above, and no strict bound.

A train of pulses of duty D has the fundamental (2/pi) sin(pi D) and harmonics (2/(n pi)) sin(n pi D) per volt. An
amplitude that is a share s of the largest (at D = 1/2) needs D = arcsin(s)/pi. Ticks make both the duty and the carrier
frequency whole: timer_hz/carrier_hz is rounded to C ticks a period, and floor(C/2) widths differ.

The band-pass between timer and amplifier: a Butterworth filter given by its zeros and poles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple, get_args

import numpy as np
from scipy.signal import butter, lfilter

from frictionloop.hardware.plate.drive_requirements import envelope, envelope_pole, time_constant_s
from frictionloop.hardware.plate.modes import resonance_hz
from frictionloop.parameters.plate_design import Carrier, PlateDesign
from frictionloop.quantities import must_be
from frictionloop.quantities.value_checks import numbers


def period_ticks(timer_hz: float, carrier_hz: float) -> int:
    """Return C, the whole number of clock ticks nearest to a carrier period.

    Raises
    ------
    FrictionloopError
        For a clock with fewer than four ticks a period, which could not even halve an amplitude.
    """
    ticks = round(timer_hz / carrier_hz)
    if ticks < 4:
        raise must_be("timer_hz", timer_hz, f"at least {4 * carrier_hz:g}", "Hz")
    return ticks


def duty_for(share: np.ndarray | float) -> np.ndarray:
    """Return the duty arcsin(s)/pi in 0 to 1/2 for shares s of the largest amplitude; beyond 0 and 1 they are cut."""
    return np.asarray(np.arcsin(np.clip(share, 0.0, 1.0)) / np.pi)


def pulse_ticks(share: np.ndarray | float, ticks: int) -> np.ndarray:
    """Return the pulse width in ticks nearest to the duty for each share, 0 to floor(C/2)."""
    return np.minimum(np.rint(duty_for(share) * ticks), ticks // 2).astype(int)


def share_of(width: np.ndarray | int, ticks: int) -> np.ndarray:
    """Return sin(pi width/C), the fundamental of pulses so wide as a share of the largest."""
    return np.asarray(np.sin(np.pi * np.asarray(width) / ticks))


def amplitude_step(share: float, ticks: int) -> float:
    """Return the distance between the two levels around a share, as a share: (pi/C) cos(pi D) or less."""
    width = min(int(duty_for(share) * ticks), ticks // 2 - 1)
    return float(share_of(width + 1, ticks) - share_of(width, ticks))


def pulses(width: np.ndarray, ticks: int, alignment: str) -> np.ndarray:
    """Return the level (0 or 1) of every tick, one row per carrier period.

    With alignment "centre" pulses grow from the middle of the period, to half a tick, so that their phase stays; with
    "edge" from its start, so that the phase of the fundamental moves by -pi D.
    """
    width = np.asarray(width)[:, None]
    start = (ticks - width) // 2 if alignment == "centre" else np.zeros_like(width)
    tick = np.arange(ticks)
    return ((tick >= start) & (tick < start + width)).astype(float)


class Analogue(NamedTuple):
    """H(s) = gain prod(s - zeros)/prod(s - poles), in rad/s."""

    zeros: np.ndarray
    poles: np.ndarray
    gain: float

    def response(self, frequency_hz: np.ndarray | float) -> np.ndarray:
        """Return H(j 2 pi f), complex, for frequencies in Hz of any shape."""
        s = 2j * np.pi * np.asarray(frequency_hz, dtype=float)[..., None]
        return np.asarray(self.gain * np.prod(s - self.zeros, axis=-1) / np.prod(s - self.poles, axis=-1))

    def residues(self) -> np.ndarray:
        """Return c of H(s) = sum c/(s - poles), for distinct poles that outnumber the zeros."""
        others = [np.prod(pole - np.delete(self.poles, i)) for i, pole in enumerate(self.poles)]
        return np.asarray(self.gain * np.prod(self.poles[:, None] - self.zeros, axis=1) / np.array(others))

    def then(self, other: Analogue) -> Analogue:
        """Return the series connection."""
        zeros, poles = np.append(self.zeros, other.zeros), np.append(self.poles, other.poles)
        return Analogue(zeros, poles, self.gain * other.gain)

    def group_delay_s(self, frequency_hz: np.ndarray | float) -> np.ndarray:
        """Return -d arg H/d omega: by how much the filter delays slow changes of a carrier's amplitude.

        d ln H/ds = sum 1/(s - zeros) - sum 1/(s - poles), and d arg H/d omega is its real part.
        """
        s = 2j * np.pi * np.asarray(frequency_hz, dtype=float)[..., None]
        return np.asarray(np.sum(1 / (s - self.poles), axis=-1).real - np.sum(1 / (s - self.zeros), axis=-1).real)


def band_pass(carrier: Carrier) -> Analogue:
    """Return the band-pass of a carrier's electronics (paper, Sec. 4.1; Butterworth and its order are assumed)."""
    edges = 2 * np.pi * np.array([carrier.band_low_hz, carrier.band_high_hz])
    return Analogue(*butter(carrier.filter_order, edges, btype="bandpass", analog=True, output="zpk"))


Source = Literal["pwm", "sine"]
"""Pulses of whole ticks, or an ideal modulated sine to compare with."""
_AT_ONCE = 256
"""Carrier periods computed at once: bounds the memory of long runs."""
STEPS = (1.0, 0.3)
"""Commands of the check as shares of a_max, each held for ten time constants."""


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
        raise must_be("source", source, "'pwm' or 'sine'")
    command = numbers("command_um", command_um, "um")
    if command.ndim != 1 or not command.size:
        raise must_be("command_um: shape", command.shape, "a list")
    carrier_hz = actual_carrier_hz(design)
    ticks = round(design.carrier.timer_hz / carrier_hz)
    most_um = design.drive.max_amplitude_um
    periods = int(command.size / design.carrier.control_hz * carrier_hz * (1 + 1e-12))
    if not periods:
        raise must_be("command_um: commands", command.size, "a carrier period long")
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


@dataclass(frozen=True)
class EnvelopeCheck:
    """Carrier level against the first-order envelope, errors as shares of a_max."""

    source: Source
    """What drove the plate."""
    filtered: bool
    """Whether the band-pass was there."""
    delay_s: float
    """Group delay of the band-pass at the carrier, by which the envelope model is delayed."""
    largest: float
    """Largest error."""
    rms: float
    """Root mean square of the error over the two steps."""
    undelayed: float
    """Largest error of the model without that delay, as the loop uses it."""
    allowed: float
    """Largest error that theory allows with the delay; without it, delay_s/T more."""


def check_envelope(design: PlateDesign, source: Source = "pwm", filtered: bool = True) -> EnvelopeCheck:
    """Return how well the first-order envelope describes a design's plate, its drive tuned to the carrier.

    Parameters
    ----------
    design : PlateDesign
        Its resonance is moved onto the frequency that the timer makes, so that nothing but the order of the model is
        compared; what a detuned drive does is in ``plate_envelope``.
    source : {"pwm", "sine"}
        What drives the plate.
    filtered : bool
        Whether the band-pass is there.

    Raises
    ------
    FrictionloopError
        As ``simulate_carrier``.
    """
    design = design.evolve({"drive.resonance_hz": actual_carrier_hz(design), "drive.detuning_hz": 0.0})
    most_um, control_hz = design.drive.max_amplitude_um, design.carrier.control_hz
    constant_s = time_constant_s(resonance_hz(design), design.drive.quality_factor)
    held = math.ceil(10 * constant_s * control_hz)
    run = simulate_carrier(design, np.repeat(np.array(STEPS) * most_um, held), source, filtered)
    delay_s = float(band_pass(design.carrier).group_delay_s(run.carrier_hz)) if filtered else 0.0
    error = (np.abs(run.envelope_um) - first_order_um(run, design, delay_s)) / most_um
    undelayed = (np.abs(run.envelope_um) - first_order_um(run, design)) / most_um
    return EnvelopeCheck(
        source=source,
        filtered=filtered,
        delay_s=delay_s,
        largest=float(np.max(np.abs(error))),
        rms=float(np.sqrt(np.mean(error**2))),
        undelayed=float(np.max(np.abs(undelayed))),
        allowed=allowed_error(design, source, filtered),
    )


def first_order_um(run: CarrierRun, design: PlateDesign, delay_s: float = 0.0) -> np.ndarray:
    """Return the amplitude of the first-order model at the times of a run, delayed, exactly (no step size)."""
    resonance, period_s = resonance_hz(design), 1 / run.carrier_hz
    pole = envelope_pole(resonance, design.drive.quality_factor)
    starts = envelope(run.command_um, period_s, pole).real
    time_s = run.time_s - delay_s
    period = np.floor(time_s / period_s).astype(int)
    known = np.clip(period, 0, None)
    target = run.command_um[known]
    found = target + (starts[known] - target) * np.exp(pole.real * (time_s - known * period_s))
    return np.asarray(np.where(period >= 0, found, 0.0))


def allowed_error(design: PlateDesign, source: Source, filtered: bool) -> float:
    """Return the error that theory allows, as a share of the step (see the top of the file)."""
    quality, carrier_hz = design.drive.quality_factor, actual_carrier_hz(design)
    allowed = 1 / quality
    if source == "pwm":
        ticks = round(design.carrier.timer_hz / carrier_hz)
        allowed += (math.pi / 4 + 3 / 4) / quality + math.pi / (2 * ticks)
    if filtered:
        allowed += _filter_spread_s(design, carrier_hz) / time_constant_s(resonance_hz(design), quality)
    return allowed


def _filter_spread_s(design: PlateDesign, carrier_hz: float) -> float:
    """Return the integral of |s(t) - H(t - delay)| over the band-pass's envelope step response s."""
    band = band_pass(design.carrier)
    delay_s = float(band.group_delay_s(carrier_hz))
    shifted = band.poles - 2j * np.pi * carrier_hz
    weights = band.residues() / (shifted * band.response(carrier_hz))
    time_s = np.linspace(0.0, 40 / -float(band.poles.real.max()), 40_001)
    step = 1 + np.sum(weights * np.exp(shifted * time_s[:, None]), axis=1)
    return float(np.trapezoid(np.abs(step - (time_s >= delay_s)), time_s))
