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

from frictionloop.hardware.sensor import springs
from frictionloop.hardware.sensor.noise_budget import noise_budget
from frictionloop.hardware.sensor.wanted import (
    AREAS,
    LARGEST_GAP_UM,
    STOUTEST,
    THINNEST_MM,
    SensorRequirement,
    check_limits,
    check_requirement,
    smallest_gap_um,
    too_quiet,
    with_electrodes,
)
from frictionloop.parameters.sensor_design import ArcSprings, SensorDesign
from frictionloop.quantities import must_be


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
        accepted = f"at least {softest:.4g} with springs.{name} = {size_mm:g}, {THINNEST_MM:g} mm thin"
        raise must_be("resonance_hz", wanted, accepted, "Hz")
    if octaves(math.log(thickest)) < 0:
        stiffest = springs.resonance_hz(thick(thickest))
        accepted = f"at most {stiffest:.4g} with springs.{name} = {size_mm:g}, {thickest:.4g} mm thick"
        raise must_be("resonance_hz", wanted, accepted, "Hz")
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
