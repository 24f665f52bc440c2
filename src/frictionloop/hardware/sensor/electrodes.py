"""The capacitors that see the frame move: C = eps0 A / e, one on either side (paper, Sec. 3.2)."""

from __future__ import annotations

from typing import NamedTuple

from scipy.constants import epsilon_0

from frictionloop.hardware.sensor import springs
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.quantities import must_be


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
