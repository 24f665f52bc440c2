"""What a force sensor of given geometry does, and what the loop's ``sensor`` block leaves out of its noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from frictionloop.hardware.sensor import baseband, front_end, noise_budget, springs
from frictionloop.hardware.sensor.electrodes import Sides, capacitance_f, check_geometry
from frictionloop.hardware.sensor.noise_budget import Budget
from frictionloop.parameters.sensor_design import SensorDesign

CONVERTER = "adc.bits"
"""Parameter of the one term that the loop makes itself, from the block's ``adc_bits`` and ``range_n``."""


class Omitted(NamedTuple):
    """Noise that a design has and its block in the loop has not."""

    at_rest_n: dict[str, float]
    """Name of the term to N rms: forces on the frame, such as vibration of the base and tilt."""
    under_load_n: float
    """What the electronics add at the end of the range to their noise at rest, N rms: the excitation's amplitude."""
    force_n: float
    """That end of the range."""

    @property
    def rest_rms_n(self) -> float:
        """All that is left out at rest, N rms."""
        return math.hypot(*self.at_rest_n.values())


def omitted(at_rest: Budget, at_range: Budget) -> Omitted:
    """Return what the block of kind "suspended" leaves out: its density is that of the electronics at rest."""
    forces_n = {term.name: term.rms_n for term in at_rest.terms if not term.white and term.parameter != CONVERTER}
    rest, load = (math.hypot(*(term.rms_n for term in each.terms if term.white)) for each in (at_rest, at_range))
    return Omitted(forces_n, math.sqrt(max(load**2 - rest**2, 0.0)), at_range.force_n)


BLOCK_TO_HZ = 500.0
"""Frequency to which the loop's block is compared with the design."""


class BlockError(NamedTuple):
    """Largest deviation of the loop's block with the delay added, up to 500 Hz."""

    gain: float
    phase_deg: float


@dataclass(frozen=True)
class SensorAnalysis:
    """The figures of one sensor design."""

    design: SensorDesign
    stiffness: springs.Stiffness
    """Of the suspension, N/m."""
    resonance_hz: float
    """First resonance along x."""
    travel_um: float
    """Displacement at the end of the range."""
    stress_mpa: float
    """Largest stress in the springs there."""
    capacitance_f: Sides
    """At rest."""
    amplitude_v: float
    """Demodulated amplitude of one side at rest, mean of both."""
    peak_v: float
    """Largest amplitude at a charge amplifier within the range, as if it did not clip."""
    clips_from_n: float | None
    """Force from which an amplifier clips; None if it does not within the range, 0 if it does at rest."""
    nonlinearity: float
    """Reading at the ends of the range, halved difference, relative to the force, minus 1: (x/e)^2 for subtraction."""
    at_rest: noise_budget.Budget
    """Noise without a force."""
    at_range: noise_budget.Budget
    """Noise at the end of the range."""
    side_density_pm_rthz: float
    """Displacement noise of one side's electronics, without the excitation's."""
    delay_s: float
    """Delay of the carrier's electronics, mostly the band-pass, which the loop's block lacks."""
    block_error: BlockError
    """What else the loop's block lacks."""

    @property
    def clips(self) -> bool:
        """Whether an amplifier clips within the range: then the sensor has no range and no block in the loop."""
        return self.clips_from_n is not None

    @property
    def dynamic_range_db(self) -> float | None:
        """Range over noise at rest, 20 log10; None if it clips."""
        return None if self.clips else 20 * math.log10(self.design.load.range_n / self.at_rest.rms_n)

    @property
    def suspended(self) -> dict[str, Any] | None:
        """Values of the ``sensor`` block of kind "suspended" that stands for it in the loop; None if it clips."""
        return None if self.clips else suspended_values(self.design)

    @property
    def omitted(self) -> Omitted | None:
        """Noise that this block leaves out; None if it clips."""
        return None if self.clips else omitted(self.at_rest, self.at_range)


def suspended_values(design: SensorDesign) -> dict[str, Any]:
    """Return the values of the loop's ``sensor`` block of kind "suspended" that stands for a design.

    Its noise density is that of the electronics at rest, before the low-pass; the converter's noise follows from its
    bits, vibration and tilt are no part of the block.
    """
    return {
        "kind": "suspended",
        "moving_mass_kg": design.moving.mass_kg,
        "resonance_hz": springs.resonance_hz(design),
        "q": design.moving.q,
        "cutoff_hz": design.filters.cutoff_hz,
        "noise_density_n_rthz": noise_budget.noise_budget(design).white_density_n_rthz,
        "adc_bits": design.adc.bits,
        "range_n": design.adc.range_n,
    }


def analyse_sensor(design: SensorDesign) -> SensorAnalysis:
    """Return what a sensor of this geometry does.

    Raises
    ------
    FrictionloopError
        For a gap that is not larger than the travel, springs that yield, a converter that ends below the force.
    """
    check_geometry(design)
    range_n, travel_m = design.load.range_n, springs.travel_m(design)
    return SensorAnalysis(
        design=design,
        stiffness=springs.stiffness(design.springs),
        resonance_hz=springs.resonance_hz(design),
        travel_um=travel_m * 1e6,
        stress_mpa=springs.peak_stress_pa(design.springs, travel_m) * 1e-6,
        capacitance_f=capacitance_f(design),
        amplitude_v=sum(front_end.amplitudes_v(design)) / 2,
        peak_v=max(front_end.peak_amplifier_v(design, force) for force in (-range_n, range_n)),
        clips_from_n=clips_from_n(design),
        nonlinearity=_nonlinearity(design),
        at_rest=noise_budget.noise_budget(design),
        at_range=noise_budget.noise_budget(design, range_n),
        side_density_pm_rthz=noise_budget.side_density_pm_rthz(design),
        delay_s=baseband.carrier_delay_s(design),
        block_error=_block_error(design),
    )


def clips_from_n(design: SensorDesign) -> float | None:
    """Return the force within the range from which a charge amplifier clips, 0 if it clips at rest, else None."""

    def above(force_n: float) -> float:
        # The plus side is the larger one, and the frame approaches it under a positive force.
        return front_end.peak_amplifier_v(design, force_n) - design.amplifier.swing_v

    if above(0.0) > 0:
        return 0.0
    range_n = design.load.range_n
    return float(brentq(above, 0.0, range_n, xtol=1e-9 * range_n)) if above(range_n) > 0 else None


def _block_error(design: SensorDesign) -> BlockError:
    frequency_hz = np.linspace(1.0, BLOCK_TO_HZ, 500)
    ratio = baseband.loop_response(design, frequency_hz) / baseband.sensor_response(design, frequency_hz)
    return BlockError(float(np.max(np.abs(np.abs(ratio) - 1))), float(np.max(np.abs(np.angle(ratio, deg=True)))))


def _nonlinearity(design: SensorDesign) -> float:
    range_n = design.load.range_n
    high, low = (
        float(front_end.readings(design, *front_end.amplitudes_v(design, force)).force_n)
        for force in (range_n, -range_n)
    )
    return (high - low) / (2 * range_n) - 1
