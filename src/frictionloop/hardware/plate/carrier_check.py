"""How far the first-order envelope that the loop uses is from the carrier-level simulation, and what theory allows.

A step of the amplitude to a_max and one down to a part of it are simulated at carrier level. Beside them stands
da/dt = (c - a)/T, delayed by the band-pass. Per unit of the step, theory allows

- 1/Q: the plate also answers the part that turns the other way, 1/(2Q), which demodulation turns into 1/(4Q) more;
- for pulses (pi/4 + 3/4)/Q: switching their constant and harmonic parts on and off rings the plate, as a force at n f
  moves it by 1/(Q (n^2 - 1)) of one at f, and n times that in velocity; and pi/(2C): half a tick of pulse width;
- for the band-pass (1/T) times the integral of |s(t) - H(t - delay)|, s its envelope's step response.

Left out is the band-pass's own brief answer to the constant and harmonic parts of the pulses, which it rejects; so with
pulses and band-pass together the sum is an estimate from above, and no strict bound.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from frictionloop.hardware.plate.carrier import CarrierRun, Source, actual_carrier_hz, simulate_carrier
from frictionloop.hardware.plate.carrier_pwm import band_pass
from frictionloop.hardware.plate.envelope import envelope, envelope_pole, time_constant_s
from frictionloop.hardware.plate.modes import resonance_hz
from frictionloop.parameters.plate_design import PlateDesign

STEPS = (1.0, 0.3)
"""Commands of the check as shares of a_max, each held for ten time constants."""


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
