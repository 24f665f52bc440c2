"""The electronics of one side as linear blocks, and what the loop sees of them without the carrier (paper, Sec. 3.2).

The frame carries the excitation, the electrode sits at the virtual ground of an op-amp A(s) = wt/(s + wt/A0), its guard
at ground. With Yf = s Cf + 1/Rf and Yn = s (C + Cpar) + Yf the op-amp gives

    V = -s (C Vexc) / (Yf + Yn/A),   noise: en Yn/(Yf + Yn/A) and i/(Yf + Yn/A),

which is -(C/Cf) Vexc and a noise gain of 1 + (C + Cpar)/Cf where the op-amp is fast and Rf large.

A real envelope m(t) on the carrier passes a block H as m -> [H(s + jw) e^(-jp) + H(s - jw) e^(jp)]/2 once it is
demodulated with the phase p of H at the carrier. This is exact but for the ripple at twice the carrier. The noise of
density S around the carrier comes out with the density [S(w + s)|H(w + s)|^2 + S(w - s)|H(w - s)|^2], which is the
factor sqrt(2) of synchronous demodulation where both are flat.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.constants import Boltzmann, epsilon_0

from frictionloop.hardware.sensor import springs
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.quantities import Lti, must_be


class Sides(NamedTuple):
    """A quantity of the two sides of a pair: ``plus`` is the side that the frame approaches under a positive force."""

    plus: float
    minus: float


def capacitance_f(design: SensorDesign, displacement_m: float = 0.0) -> Sides:
    """Return C+ and C- = eps0 A (1 +- imbalance)/(e -+ x) in F at a displacement x in m."""
    electrodes = design.electrodes
    gap_m, flat = electrodes.gap_um * 1e-6, epsilon_0 * electrodes.area_mm2 * 1e-6
    unequal = electrodes.imbalance
    return Sides(flat * (1 + unequal) / (gap_m - displacement_m), flat * (1 - unequal) / (gap_m + displacement_m))


def electrostatic_n_per_m(design: SensorDesign) -> float:
    """Return the negative stiffness that the excitation adds at rest, V_rms^2 (C+ + C-)/e^2, in N/m."""
    both = sum(capacitance_f(design))
    return design.excitation.amplitude_v**2 / 2 * both / (design.electrodes.gap_um * 1e-6) ** 2


def check_geometry(design: SensorDesign) -> None:
    """Refuse a design that cannot work at all.

    Raises
    ------
    FrictionloopError
        For a gap that is not larger than the travel, leaves that yield, a converter that ends below the force,
        an excitation that its source does not give.
    """
    travel_um, range_n = springs.travel_m(design) * 1e6, design.load.range_n
    gap_um = design.electrodes.gap_um
    if not gap_um > travel_um:
        raise must_be("electrodes.gap_um", gap_um, f"above the travel of {travel_um:.4g}", "um")
    stress_mpa = springs.peak_stress_pa(design.springs, travel_um * 1e-6) * 1e-6
    if stress_mpa >= design.springs.yield_mpa:
        most_n = range_n * design.springs.yield_mpa / stress_mpa
        raise must_be("load.range_n", range_n, f"below {most_n:.4g}, by springs.yield_mpa", "N")
    if design.adc.range_n < range_n:
        raise must_be("adc.range_n", design.adc.range_n, f"at least load.range_n = {range_n:g}", "N")
    excitation = design.excitation
    if excitation.amplitude_v > excitation.max_amplitude_v:
        accepted = f"at most excitation.max_amplitude_v = {excitation.max_amplitude_v:g}"
        raise must_be("excitation.amplitude_v", excitation.amplitude_v, accepted, "V")


Frequencies = np.ndarray
LOW_HZ = 1.0
"""A slow signal: where the delay is taken and densities are quoted."""


class ChargeAmplifierBlocks(NamedTuple):
    """The op-amp stage, from each of its inputs to its output voltage."""

    charge: Lti
    """From C Vexc (coulomb) to V; the sign is left to the demodulator."""
    voltage_noise: Lti
    """From the op-amp's voltage noise to V."""
    current_noise: Lti
    """From a current into the virtual ground (A) to V."""


def charge_amplifier(design: SensorDesign, electrode_f: float) -> ChargeAmplifierBlocks:
    """Return the op-amp stage with an electrode of ``electrode_f`` farad at its input."""
    amplifier = design.amplifier
    feedback_f, leak_s = amplifier.feedback_pf * 1e-12, 1e-6 / amplifier.feedback_mohm
    input_f = electrode_f + amplifier.parasitic_pf * 1e-12 + feedback_f
    turn = 2 * math.pi * amplifier.gain_bandwidth_mhz * 1e6
    corner = turn / amplifier.open_loop_gain
    # Yf wt + Yn (s + wt/A0), all divided by wt.
    den = (
        input_f / turn,
        feedback_f + (leak_s + input_f * corner) / turn,
        leak_s * (1 + corner / turn),
    )
    return ChargeAmplifierBlocks(Lti((1.0, 0.0), den), Lti((input_f, leak_s), den), Lti((1.0,), den))


class BandpassParts(NamedTuple):
    """Values of the selective filter: a resistor, then coil and capacitor in parallel to ground."""

    resistor_ohm: float
    coil_h: float
    capacitor_f: float


def bandpass_parts(design: SensorDesign) -> BandpassParts:
    """Return the parts that tune the filter to the excitation: C = 1/(w^2 L), R = Q w L."""
    omega, coil_h = 2 * math.pi * design.excitation.frequency_hz, design.filters.bandpass_coil_uh * 1e-6
    return BandpassParts(design.filters.bandpass_q * omega * coil_h, coil_h, 1 / (omega**2 * coil_h))


def bandpass(design: SensorDesign) -> Lti:
    """Return H(s) = (s w/Q)/(s^2 + s w/Q + w^2), 1 at the excitation's frequency."""
    omega = 2 * math.pi * design.excitation.frequency_hz
    width = omega / design.filters.bandpass_q
    return Lti((width, 0.0), (1.0, width, omega**2))


def lowpass(design: SensorDesign) -> Lti:
    """Return H(s) = 1/(1 + s/wc), the filter after the demodulator."""
    return Lti((1.0,), (1 / (2 * math.pi * design.filters.cutoff_hz), 1.0))


def lowpass_resistor_ohm(design: SensorDesign) -> float:
    """Return the resistor of the low-pass, 1/(wc C)."""
    return 1 / (2 * math.pi * design.filters.cutoff_hz * design.filters.lowpass_nf * 1e-9)


def carrier_gain(design: SensorDesign) -> complex:
    """Return demodulated volts per coulomb of C Vexc, with its phase: amplifier and band-pass at the excitation."""
    frequency_hz = np.array(design.excitation.frequency_hz)
    at_rest = charge_amplifier(design, sum(capacitance_f(design)) / 2).charge
    return complex(at_rest.response(frequency_hz) * bandpass(design).response(frequency_hz))


def amplitudes_v(design: SensorDesign, force_n: float = 0.0) -> Sides:
    """Return the amplitudes V+ and V- that the demodulators give under a steady force."""
    per_coulomb = abs(carrier_gain(design)) * design.excitation.amplitude_v
    sides = capacitance_f(design, springs.travel_m(design, force_n))
    return Sides(per_coulomb * sides.plus, per_coulomb * sides.minus)


class Readings(NamedTuple):
    """The force that the two amplitudes stand for, and how it changes with each of them."""

    force_n: np.ndarray
    per_plus_n_per_v: np.ndarray
    per_minus_n_per_v: np.ndarray


def readings(design: SensorDesign, plus_v: np.ndarray | float, minus_v: np.ndarray | float) -> Readings:
    """Return the force in N read from demodulated amplitudes in V, straight at zero force.

    Subtraction: F = k e (V+ - V-)/(V+ + V-)_rest. Ratio: F = k e (V+ - V-)/(V+ + V-), which is linear in x/e. What the
    imbalance gives at rest is taken off.
    """
    full_n = springs.stiffness(design.springs).x_n_per_m * design.electrodes.gap_um * 1e-6
    unequal = design.electrodes.imbalance
    plus, minus = np.asarray(plus_v, float), np.asarray(minus_v, float)
    if design.readout.form == "subtraction":
        slope = full_n / sum(amplitudes_v(design)) * np.ones_like(plus)
        return Readings(slope * (plus - minus) - full_n * unequal, slope, -slope)
    # With unequal sides r = (d + x/e)/(1 + d x/e), whose slope at rest is 1 - d^2.
    scale = full_n / (1 - unequal**2)
    both = plus + minus
    return Readings(scale * ((plus - minus) / both - unequal), 2 * scale * minus / both**2, -2 * scale * plus / both**2)


def peak_amplifier_v(design: SensorDesign, force_n: float) -> float:
    """Return the largest output of either charge amplifier under a steady force, V zero-to-peak."""
    frequency_hz = np.array(design.excitation.frequency_hz)
    largest = max(capacitance_f(design, springs.travel_m(design, force_n)))
    gain = charge_amplifier(design, largest).charge.response(frequency_hz)
    return float(abs(gain)) * largest * design.excitation.amplitude_v


def thermal_v_rthz(design: SensorDesign, resistor_ohm: float) -> float:
    """Return the thermal noise of a resistor, sqrt(4 kB T R), in V/rtHz."""
    return math.sqrt(4 * Boltzmann * design.environment.temperature_k * resistor_ohm)


def suspension(design: SensorDesign) -> Lti:
    """Return force to spring force, wm^2/(s^2 + s wm/Q + wm^2), 1 at rest (paper, Sec. 3.1)."""
    omega = 2 * math.pi * springs.resonance_hz(design)
    return Lti((1.0,), (1 / omega**2, 1 / (design.moving.q * omega), 1.0))


def carrier_chain(design: SensorDesign) -> Lti:
    """Return charge amplifier and band-pass in series, from C Vexc to the demodulator."""
    electrode_f = sum(capacitance_f(design)) / 2
    return charge_amplifier(design, electrode_f).charge * bandpass(design)


def envelope_response(design: SensorDesign, frequency_hz: Frequencies) -> np.ndarray:
    """Return the response of the electronics to a slow change of capacitance, relative to its value at rest.

    Frequencies are below that of the excitation.
    """
    chain, carrier_hz = carrier_chain(design), design.excitation.frequency_hz
    frequency = np.asarray(frequency_hz, float)
    at_carrier = chain.response(np.array(carrier_hz))
    above = chain.response(carrier_hz + frequency) / at_carrier
    below = np.conj(chain.response(carrier_hz - frequency) / at_carrier)
    return np.asarray((above + below) / 2 * lowpass(design).response(frequency))


def sensor_response(design: SensorDesign, frequency_hz: Frequencies) -> np.ndarray:
    """Return force on the plate to measured force for small forces: suspension times electronics; 1 at rest."""
    return np.asarray(suspension(design).response(frequency_hz) * envelope_response(design, frequency_hz))


def loop_response(design: SensorDesign, frequency_hz: Frequencies) -> np.ndarray:
    """Return what the loop's sensor block has in its place: suspension, one pole, and the carrier's delay."""
    response = (suspension(design) * lowpass(design)).response(frequency_hz)
    return np.asarray(response * np.exp(-2j * np.pi * np.asarray(frequency_hz) * carrier_delay_s(design)))


def carrier_delay_s(design: SensorDesign) -> float:
    """Return the delay of slow signals in the carrier's electronics, in s: the loop's block lacks it.

    Nearly all of it is the band-pass, Q/(pi f).
    """
    slow = np.array(LOW_HZ)
    electronics = envelope_response(design, slow) / lowpass(design).response(slow)
    return float(-np.angle(electronics) / (2 * np.pi * LOW_HZ))


def demodulated_density(
    design: SensorDesign, density: Callable[[Frequencies], Any], frequency_hz: Frequencies
) -> np.ndarray:
    """Return the noise density after the demodulator, before the low-pass, from that at its input; both in V/rtHz."""
    carrier_hz, frequency = design.excitation.frequency_hz, np.asarray(frequency_hz, float)
    return np.sqrt(density(carrier_hz + frequency) ** 2 + density(np.abs(carrier_hz - frequency)) ** 2)
