"""From a requirement to a geometry: what `sensor` proposes for resonance, range and noise.

The resonance sets the springs' thickness, and with the range the travel. The noise then sets the gap: the largest one
that meets it is proposed, because a wide gap is easier to make and straighter, and a narrow one is only quieter. The
excitation is the largest that neither the source nor the amplifiers limit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from scipy.optimize import brentq

from frictionloop.hardware.sensor import front_end, springs
from frictionloop.hardware.sensor.front_end import check_geometry
from frictionloop.hardware.sensor.noise_budget import Budget, noise_budget
from frictionloop.parameters.sensor_design import ArcSprings, SensorDesign
from frictionloop.quantities import FrictionloopError, must_be, unit_of
from frictionloop.quantities.value_checks import ABOVE_0, number

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

    def of(self, budget: Budget) -> float:
        """Return the noise of the kind that is asked for."""
        return budget.rms_n if self.noise_rms_n is not None else budget.white_density_n_rthz


def check_requirement(requirement: SensorRequirement) -> None:
    """Refuse values that are not positive, and two noises or none."""
    given = {name: value for name, value in vars(requirement).items() if value is not None}
    for name, value in given.items():
        number(name, value, unit_of(name), ABOVE_0)
    if ("noise_rms_n" in given) == ("noise_density_n_rthz" in given):
        noises = [name for name in given if name.startswith("noise_")]
        raise must_be("noise_rms_n, noise_density_n_rthz", noises, "one of them")


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
    fixed = [term for term in noise_budget(design).terms if not term.white]
    floor_n, largest = math.hypot(*(term.rms_n for term in fixed)), max(fixed, key=lambda term: term.rms_n)
    if floor_n >= requirement.noise_rms_n:
        raise must_be("noise_rms_n", requirement.noise_rms_n, f"above {floor_n:.3g}, most {largest.parameter}", "N")


def too_quiet(requirement: SensorRequirement, design: SensorDesign, area_mm2: float) -> FrictionloopError:
    """Return the error that says what keeps the noise up with the smallest gap and the largest electrodes."""
    gap_um = smallest_gap_um(design)
    best = noise_budget(with_electrodes(design, gap_um, area_mm2))
    name, wanted, unit = requirement.noise
    reached = requirement.of(best)
    terms = best.terms if name == "noise_rms_n" else tuple(term for term in best.terms if term.white)
    largest = max(terms, key=lambda term: term.rms_n)
    where = f"at {gap_um:.4g} um and {area_mm2:g} mm2, most {largest.parameter}"
    return must_be(name, wanted, f"at least {reached:.3g} {where}", unit)


class Option(NamedTuple):
    """A geometry that meets the noise with one electrode area; None if no gap does."""

    area_mm2: float
    design: SensorDesign | None

    def to_dict(self) -> dict[str, Any]:
        """Return area, gap, gap over travel, excitation and the largest noise under load."""
        if self.design is None:
            return dict.fromkeys(("area_mm2", "gap_um", "gap_per_travel", "amplitude_v", "largest", "rms_un")) | {
                "area_mm2": self.area_mm2
            }
        design, largest = self.design, noise_budget(self.design, self.design.load.range_n).dominant
        return {
            "area_mm2": self.area_mm2,
            "gap_um": design.electrodes.gap_um,
            "gap_per_travel": design.electrodes.gap_um / (1e6 * springs.travel_m(design)),
            "amplitude_v": design.excitation.amplitude_v,
            "largest": largest.name,
            "rms_un": 1e6 * largest.rms_n,
        }


@dataclass(frozen=True)
class SensorProposal:
    """The geometry proposed, and those with other areas."""

    requirement: SensorRequirement
    design: SensorDesign
    options: tuple[Option, ...]

    @property
    def gap_is_largest(self) -> bool:
        """Whether even the largest gap is quieter than was asked."""
        return self.design.electrodes.gap_um >= LARGEST_GAP_UM


def propose_sensor(requirement: SensorRequirement, base: SensorDesign | None = None) -> SensorProposal:
    """Return a geometry that meets a requirement.

    Parameters
    ----------
    requirement : SensorRequirement
        Resonance, range and one of both noises, all positive.
    base : SensorDesign, optional
        Everything that is not searched: mass, shape and width of the springs, electronics, surroundings.

    Raises
    ------
    FrictionloopError
        For a requirement that is not positive or that cannot be met, saying what limits.
    """
    check_requirement(requirement)
    design = _with_springs(requirement, SensorDesign() if base is None else base)
    check_limits(requirement, design)
    area = design.electrodes.area_mm2
    options = tuple(Option(factor * area, _with_gap(requirement, design, factor * area)) for factor in AREAS)
    found = next((option.design for option in options if option.design is not None), None)
    if found is None:
        raise too_quiet(requirement, design, max(option.area_mm2 for option in options))
    return SensorProposal(requirement, found, tuple(sorted(options)))


def _with_springs(requirement: SensorRequirement, base: SensorDesign) -> SensorDesign:
    """Return the design with the thickness that gives the resonance, and with the range."""
    wanted = requirement.resonance_hz

    def thick(thickness_mm: float) -> SensorDesign:
        leaves = base.springs.model_copy(update={"thickness_mm": thickness_mm})
        return base.model_copy(update={"springs": leaves})

    def octaves(log_mm: float) -> float:
        return math.log(springs.resonance_hz(thick(math.exp(log_mm))) / wanted)

    name = "radius_mm" if isinstance(base.springs, ArcSprings) else "length_mm"
    size_mm = float(getattr(base.springs, name))
    thickest = STOUTEST * size_mm
    if octaves(math.log(THINNEST_MM)) > 0:
        softest = springs.resonance_hz(thick(THINNEST_MM))
        raise must_be("resonance_hz", wanted, f"at least {softest:.4g}, by springs.{name}", "Hz")
    if octaves(math.log(thickest)) < 0:
        stiffest = springs.resonance_hz(thick(thickest))
        raise must_be("resonance_hz", wanted, f"at most {stiffest:.4g}, by springs.{name}", "Hz")
    thickness = math.exp(brentq(octaves, math.log(THINNEST_MM), math.log(thickest), xtol=1e-14))
    design = thick(thickness)
    return design.model_copy(
        update={
            "load": design.load.model_copy(update={"range_n": requirement.range_n}),
            "adc": design.adc.model_copy(update={"range_n": requirement.range_n}),
        }
    )


def _with_gap(requirement: SensorRequirement, design: SensorDesign, area_mm2: float) -> SensorDesign | None:
    """Return the design with the largest gap that meets the noise, None if none does."""
    _, wanted, _ = requirement.noise

    def above(log_um: float) -> float:
        return math.log(requirement.of(noise_budget(with_electrodes(design, math.exp(log_um), area_mm2))) / wanted)

    low, high = math.log(smallest_gap_um(design)), math.log(LARGEST_GAP_UM)
    if above(high) <= 0:
        return with_electrodes(design, LARGEST_GAP_UM, area_mm2)
    if above(low) > 0:
        return None
    return with_electrodes(design, math.exp(brentq(above, low, high, xtol=1e-12)), area_mm2)
