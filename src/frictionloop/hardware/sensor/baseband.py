"""The sensor seen by the loop: what the carrier's electronics do to a slow signal, without the carrier.

A real envelope m(t) on the carrier passes a block H as m -> [H(s + jw) e^(-jp) + H(s - jw) e^(jp)]/2 once it is
demodulated with the phase p of H at the carrier. This is exact but for the ripple at twice the carrier. The noise of
density S around the carrier comes out with the density [S(w + s)|H(w + s)|^2 + S(w - s)|H(w - s)|^2], which is the
factor sqrt(2) of synchronous demodulation where both are flat.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from frictionloop.hardware.sensor import front_end, springs
from frictionloop.hardware.sensor.electrodes import capacitance_f
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.quantities import Lti

Frequencies = np.ndarray
LOW_HZ = 1.0
"""A slow signal: where the delay is taken and densities are quoted."""


def suspension(design: SensorDesign) -> Lti:
    """Return force to spring force, wm^2/(s^2 + s wm/Q + wm^2), 1 at rest (paper, Sec. 3.1)."""
    omega = 2 * math.pi * springs.resonance_hz(design)
    return Lti((1.0,), (1 / omega**2, 1 / (design.moving.q * omega), 1.0))


def carrier_chain(design: SensorDesign) -> Lti:
    """Return charge amplifier and band-pass in series, from C Vexc to the demodulator."""
    electrode_f = sum(capacitance_f(design)) / 2
    return front_end.charge_amplifier(design, electrode_f).charge * front_end.bandpass(design)


def envelope_response(design: SensorDesign, frequency_hz: Frequencies) -> np.ndarray:
    """Return the response of the electronics to a slow change of capacitance, relative to its value at rest.

    Frequencies are below that of the excitation.
    """
    chain, carrier_hz = carrier_chain(design), design.excitation.frequency_hz
    frequency = np.asarray(frequency_hz, float)
    at_carrier = chain.response(np.array(carrier_hz))
    above = chain.response(carrier_hz + frequency) / at_carrier
    below = np.conj(chain.response(carrier_hz - frequency) / at_carrier)
    return np.asarray((above + below) / 2 * front_end.lowpass(design).response(frequency))


def sensor_response(design: SensorDesign, frequency_hz: Frequencies) -> np.ndarray:
    """Return force on the plate to measured force for small forces: suspension times electronics; 1 at rest."""
    return np.asarray(suspension(design).response(frequency_hz) * envelope_response(design, frequency_hz))


def loop_response(design: SensorDesign, frequency_hz: Frequencies) -> np.ndarray:
    """Return what the loop's sensor block has in its place: suspension, one pole, and the carrier's delay."""
    response = (suspension(design) * front_end.lowpass(design)).response(frequency_hz)
    return np.asarray(response * np.exp(-2j * np.pi * np.asarray(frequency_hz) * carrier_delay_s(design)))


def carrier_delay_s(design: SensorDesign) -> float:
    """Return the delay of slow signals in the carrier's electronics, in s: the loop's block lacks it.

    Nearly all of it is the band-pass, Q/(pi f).
    """
    slow = np.array(LOW_HZ)
    electronics = envelope_response(design, slow) / front_end.lowpass(design).response(slow)
    return float(-np.angle(electronics) / (2 * np.pi * LOW_HZ))


def demodulated_density(
    design: SensorDesign, density: Callable[[Frequencies], Any], frequency_hz: Frequencies
) -> np.ndarray:
    """Return the noise density after the demodulator, before the low-pass, from that at its input; both in V/rtHz."""
    carrier_hz, frequency = design.excitation.frequency_hz, np.asarray(frequency_hz, float)
    return np.sqrt(density(carrier_hz + frequency) ** 2 + density(np.abs(carrier_hz - frequency)) ** 2)
