"""What to change on an ultrasonic plate to get a wanted frequency or envelope bandwidth."""

from __future__ import annotations

import math
from dataclasses import dataclass

from frictionloop.hardware.plate.envelope import quality_for_bandwidth
from frictionloop.hardware.plate.modes import PlateMode, nearest_mode, resonance_hz, thickness_for_mm
from frictionloop.parameters.plate_design import PlateDesign


@dataclass(frozen=True)
class Wanted:
    """What would give a frequency or a bandwidth; NaN or None where nothing was asked."""

    nearest: PlateMode | None
    """Mode of this plate nearest to the frequency."""
    thickness_mm: float
    """Thickness at which the design's number of lines has the frequency."""
    quality_factor: float
    """Q that gives the bandwidth, at the frequency if one is asked for, else at the design's resonance."""


def plate_for(design: PlateDesign, frequency_hz: float | None = None, bandwidth_hz: float | None = None) -> Wanted:
    """Return which mode, thickness and Q give a wanted frequency and envelope bandwidth.

    Parameters
    ----------
    design : PlateDesign
        Glass, size and mode to start from.
    frequency_hz, bandwidth_hz : float, optional
        What is wanted, positive.

    Raises
    ------
    FrictionloopError
        For a frequency or a bandwidth that no mode, thickness or Q gives.
    """
    side_mm, thickness_mm = design.geometry.side_mm, design.geometry.thickness_mm
    nearest, needed_mm, quality = None, math.nan, math.nan
    if frequency_hz is not None:
        nearest = nearest_mode(frequency_hz, side_mm, thickness_mm, design.glass)
        needed_mm = thickness_for_mm(frequency_hz, design.geometry.nodal_lines, side_mm, design.glass)
    if bandwidth_hz is not None:
        carrier = resonance_hz(design) if frequency_hz is None else frequency_hz
        quality = quality_for_bandwidth(carrier, bandwidth_hz)
    return Wanted(nearest, needed_mm, quality)
