"""What the loop's ``sensor`` block leaves out of a sensor's noise."""

from __future__ import annotations

import math
from typing import NamedTuple

from frictionloop.hardware.sensor.noise_budget import Budget

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
