"""What is asked of a force sensor, which geometries a search may take, and the line that says why none will do."""

from __future__ import annotations

import math
from dataclasses import dataclass

from frictionloop.hardware.sensor import front_end, noise_budget, springs
from frictionloop.hardware.sensor.electrodes import check_geometry
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.quantities import FrictionloopError, must_be, unit_of

SMALLEST_GAP_UM, LARGEST_GAP_UM = 30.0, 500.0
"""Gaps that a workshop holds, and beyond which an electrode's edges matter (both assumed)."""
GAP_PER_TRAVEL = 2.0
"""The gap is at least this many times the travel (assumed)."""
AREAS = (1.0, 0.5, 2.0, 4.0)
"""Electrode areas tried, as factors on the given one; the first that can meet the noise is proposed."""
HEADROOM = 0.9
"""Share of the amplifier's swing used at the end of the range (assumed)."""
THINNEST_MM, STOUTEST = 0.1, 0.25
"""Thinnest leaf that can be milled, largest thickness over radius or length that still is a thin beam (assumed)."""


@dataclass(frozen=True)
class SensorRequirement:
    """What a sensor has to do."""

    resonance_hz: float
    """First resonance."""
    range_n: float
    """Largest force."""
    noise_rms_n: float | None = None
    """All noise of the output at rest, rms; or"""
    noise_density_n_rthz: float | None = None
    """the electronics' noise before the low-pass."""

    @property
    def noise(self) -> tuple[str, float, str]:
        """Name, value and unit of the noise that is asked for."""
        if self.noise_rms_n is not None:
            return "noise_rms_n", self.noise_rms_n, "N"
        return "noise_density_n_rthz", self.noise_density_n_rthz or math.nan, "N/rtHz"

    def of(self, budget: noise_budget.Budget) -> float:
        """Return the noise of the kind that is asked for."""
        return budget.rms_n if self.noise_rms_n is not None else budget.white_density_n_rthz


def check_requirement(requirement: SensorRequirement) -> None:
    """Refuse values that are not positive, and two noises or none."""
    given = {name: value for name, value in vars(requirement).items() if value is not None}
    for name, value in given.items():
        if not (math.isfinite(value) and value > 0):
            raise must_be(name, float(value), "a positive number", unit_of(name))
    if ("noise_rms_n" in given) == ("noise_density_n_rthz" in given):
        raise FrictionloopError("noise_rms_n, noise_density_n_rthz: one of them is needed, not both")


def with_electrodes(design: SensorDesign, gap_um: float, area_mm2: float) -> SensorDesign:
    """Return the design with this gap and area, and with the largest excitation that nothing limits."""
    electrodes = design.electrodes.model_copy(update={"gap_um": gap_um, "area_mm2": area_mm2})
    changed = design.model_copy(update={"electrodes": electrodes})
    per_volt = front_end.peak_amplifier_v(changed, changed.load.range_n) / changed.excitation.amplitude_v
    amplitude_v = min(changed.excitation.max_amplitude_v, HEADROOM * changed.amplifier.swing_v / per_volt)
    return changed.model_copy(update={"excitation": changed.excitation.model_copy(update={"amplitude_v": amplitude_v})})


def smallest_gap_um(design: SensorDesign) -> float:
    """Return the smallest gap that a search may take."""
    return max(SMALLEST_GAP_UM, GAP_PER_TRAVEL * springs.travel_m(design) * 1e6)


def check_limits(requirement: SensorRequirement, design: SensorDesign) -> None:
    """Refuse what no gap can change: springs that yield, a travel beyond any gap, noise from elsewhere."""
    travel_um = springs.travel_m(design) * 1e6
    if GAP_PER_TRAVEL * travel_um > LARGEST_GAP_UM:
        most_n = requirement.range_n * LARGEST_GAP_UM / (GAP_PER_TRAVEL * travel_um)
        raise must_be("range_n", requirement.range_n, f"at most {most_n:.3g} at {requirement.resonance_hz:g} Hz", "N")
    check_geometry(with_electrodes(design, LARGEST_GAP_UM, design.electrodes.area_mm2))
    if requirement.noise_rms_n is None:
        return
    fixed = [term for term in noise_budget.noise_budget(design).terms if not term.white]
    floor_n, largest = math.hypot(*(term.rms_n for term in fixed)), max(fixed, key=lambda term: term.rms_n)
    if floor_n >= requirement.noise_rms_n:
        raise must_be("noise_rms_n", requirement.noise_rms_n, f"above {floor_n:.3g}, most {largest.parameter}", "N")


def too_quiet(requirement: SensorRequirement, design: SensorDesign, area_mm2: float) -> FrictionloopError:
    """Return the error that says what keeps the noise up with the smallest gap and the largest electrodes."""
    gap_um = smallest_gap_um(design)
    best = noise_budget.noise_budget(with_electrodes(design, gap_um, area_mm2))
    name, wanted, unit = requirement.noise
    reached = requirement.of(best)
    terms = best.terms if name == "noise_rms_n" else tuple(term for term in best.terms if term.white)
    largest = max(terms, key=lambda term: term.rms_n)
    where = f"at {gap_um:.4g} um and {area_mm2:g} mm2, most {largest.parameter}"
    return must_be(name, wanted, f"at least {reached:.3g} {where}", unit)
