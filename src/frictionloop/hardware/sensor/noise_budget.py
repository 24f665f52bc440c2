"""The noise of the sensor, term by term, referred to newtons: density at low frequency and rms of the output."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.constants import Boltzmann
from scipy.constants import g as GRAVITY

from frictionloop.hardware.sensor import front_end, springs
from frictionloop.hardware.sensor.front_end import capacitance_f
from frictionloop.parameters.sensor_design import SensorDesign

EXCITATION = "excitation.amplitude_noise_rthz"
"""Parameter of the term that grows with the force."""


class Term(NamedTuple):
    """One source of noise."""

    name: str
    density_n_rthz: float
    """N/rtHz at 1 Hz; NaN for what drifts slowly."""
    rms_n: float
    """Standard deviation of the sampled output, N."""
    parameter: str
    """The parameter that sets it."""
    white: bool
    """Whether it is made by the electronics before the low-pass, so that the loop's block has it in its density."""


class Budget(NamedTuple):
    """All terms at one force."""

    force_n: float
    terms: tuple[Term, ...]

    @property
    def rms_n(self) -> float:
        """Root of the sum of squares of all terms."""
        return math.sqrt(sum(term.rms_n**2 for term in self.terms))

    @property
    def white_density_n_rthz(self) -> float:
        """Density of the electronics before the low-pass: ``noise_density_n_rthz`` of the loop's sensor block."""
        return math.sqrt(sum(term.density_n_rthz**2 for term in self.terms if term.white))

    @property
    def dominant(self) -> Term:
        """The largest term."""
        return max(self.terms, key=lambda term: term.rms_n)

    def to_dict(self) -> dict[str, Any]:
        """Return it by name, with the sums."""
        sums = {"rms_n": self.rms_n, "white_density_n_rthz": self.white_density_n_rthz, "dominant": self.dominant.name}
        return {"force_n": self.force_n, **sums, "terms": [term._asdict() for term in self.terms]}


def frequency_grid(design: SensorDesign) -> np.ndarray:
    """Return frequencies in Hz fine enough to integrate the resonance and wide enough for the low-pass."""
    resonance = springs.resonance_hz(design)
    wide = np.geomspace(1e-3, 0.8 * design.excitation.frequency_hz, 4000)
    # Offsets from the peak in equal ratios of its width follow its flanks.
    near = resonance / design.moving.q * np.geomspace(1e-3, 1e3, 2000)
    around = np.concatenate([resonance - near, [resonance], resonance + near])
    return np.union1d(wide, around[(around > wide[0]) & (around < wide[-1])])


def noise_budget(design: SensorDesign, force_n: float = 0.0) -> Budget:
    """Return every noise term under a steady force in N, within the range.

    Per side: the op-amp's voltage noise times 1 + (C + Cpar)/Cf with its current noise, the thermal noise of Rf and of
    the filters, all times sqrt(2) by demodulation; both sides add in power. The excitation's amplitude noise n enters
    as (V+ - V-) n in the subtraction and not at all in the ratio. The converter adds LSB/sqrt(12). The suspension has
    sqrt(4 kB T c), c = sqrt(k m)/Q, of its own, passes the base's vibration as m a, and its tilt as m g t.
    """
    grid = frequency_grid(design)
    electronics = _electronics(design, force_n, grid)
    force_gain = np.abs(front_end.sensor_response(design, grid))
    stiffness = springs.stiffness(design.springs).x_n_per_m
    mass, surroundings, adc = design.moving.mass_kg, design.environment, design.adc
    damping = math.sqrt(stiffness * mass) / design.moving.q
    thermal_n = math.sqrt(4 * Boltzmann * surroundings.temperature_k * damping)
    step_rms_n = 2 * adc.range_n / 2**adc.bits / math.sqrt(12)
    tilt_n = mass * GRAVITY * surroundings.tilt_urad * 1e-6
    vibration_n = mass * surroundings.vibration_m_s2_rthz

    def term(name: str, density: np.ndarray, parameter: str, white: bool) -> Term:
        low = float(np.interp(front_end.LOW_HZ, grid, density))
        return Term(name, low, math.sqrt(float(np.trapezoid(density**2, grid))), parameter, white)

    return Budget(
        force_n,
        (
            *(term(name, density, parameter, True) for name, density, parameter in electronics),
            Term("ADC quantisation", step_rms_n / math.sqrt(adc.rate_hz / 2), step_rms_n, "adc.bits", False),
            term("thermomechanical", thermal_n * force_gain, "moving.q", False),
            term("base vibration", vibration_n * force_gain, "environment.vibration_m_s2_rthz", False),
            Term("tilt", math.nan, tilt_n, "environment.tilt_urad", False),
        ),
    )


def _electronics(design: SensorDesign, force_n: float, grid: np.ndarray) -> list[tuple[str, np.ndarray, str]]:
    """Return name, density in N/rtHz over the grid and parameter of what passes the low-pass."""
    volts = front_end.amplitudes_v(design, force_n)
    slopes = front_end.readings(design, volts.plus, volts.minus)
    lowpass = np.abs(front_end.lowpass(design).response(grid))
    sides = capacitance_f(design, springs.travel_m(design, force_n))
    weights = abs(float(slopes.per_plus_n_per_v)), abs(float(slopes.per_minus_n_per_v))
    amplifier, filters = design.amplifier, design.filters

    def both(source: Callable[[float, np.ndarray], np.ndarray]) -> np.ndarray:
        squares = [
            (weight * front_end.demodulated_density(design, partial(source, side), grid)) ** 2
            for side, weight in zip(sides, weights, strict=True)
        ]
        return np.asarray(np.sqrt(sum(squares)) * lowpass)

    def tuned(f: np.ndarray) -> np.ndarray:
        return np.abs(front_end.bandpass(design).response(f))

    def of_amplifier(side: float, f: np.ndarray) -> np.ndarray:
        blocks = front_end.charge_amplifier(design, side)
        voltage = np.abs(blocks.voltage_noise.response(f)) * amplifier.noise_nv_rthz * 1e-9
        current = np.abs(blocks.current_noise.response(f)) * amplifier.current_noise_fa_rthz * 1e-15
        return np.asarray(np.hypot(voltage, current) * tuned(f))

    def of_feedback(side: float, f: np.ndarray) -> np.ndarray:
        ohm = amplifier.feedback_mohm * 1e6
        current = front_end.thermal_v_rthz(design, ohm) / ohm
        return np.asarray(
            np.abs(front_end.charge_amplifier(design, side).current_noise.response(f)) * current * tuned(f)
        )

    def of_filters(_: float, f: np.ndarray) -> np.ndarray:
        resistor = front_end.thermal_v_rthz(design, front_end.bandpass_parts(design).resistor_ohm)
        return np.asarray(np.hypot(resistor * tuned(f), filters.buffer_noise_nv_rthz * 1e-9))

    slow = front_end.thermal_v_rthz(design, front_end.lowpass_resistor_ohm(design)) * math.hypot(*weights) * lowpass
    unequal_n = volts.plus * float(slopes.per_plus_n_per_v) + volts.minus * float(slopes.per_minus_n_per_v)
    envelope = np.abs(front_end.envelope_response(design, grid))
    return [
        ("amplifier voltage", both(of_amplifier), "amplifier.noise_nv_rthz"),
        ("Rf thermal", both(of_feedback), "amplifier.feedback_mohm"),
        ("filters", np.hypot(both(of_filters), slow), "filters.bandpass_coil_uh"),
        (
            "excitation amplitude",
            abs(unequal_n) * design.excitation.amplitude_noise_rthz * envelope,
            EXCITATION,
        ),
    ]


def side_density_pm_rthz(design: SensorDesign) -> float:
    """Return the noise of one side's electronics at rest as a displacement, pm/rtHz: the paper's "0.5 pm".

    The terms of the budget without the excitation's, whose two sides are equal, times sqrt(2).
    """
    terms = noise_budget(design).terms
    own_n = math.sqrt(sum(t.density_n_rthz**2 for t in terms if t.white and not t.name.startswith("excitation")))
    return math.sqrt(2) * own_n / springs.stiffness(design.springs).x_n_per_m * 1e12
