"""What the noise of a calibration bench should come to, by cause."""

from __future__ import annotations

import math
from typing import NamedTuple

from frictionloop.identification.rigs.sensor_rig import covariance


class FloorTerms(NamedTuple):
    """Standard deviations of the reading in N, by cause, with the sensor's gain taken as 1."""

    electronics_n: float
    """White noise below the pole."""
    base_n: float
    """Acceleration of the base, passed and at its resonance amplified by the suspension."""
    converter_n: float
    """A step over sqrt(12): what a converter adds to noise wider than a step."""

    @property
    def rms_n(self) -> float:
        """All together."""
        return math.hypot(*self)


def floor_terms(bench):
    """Return what the noise should come to, from the covariance of the sensor's equations in closed form."""

    def alone(overrides):
        return math.sqrt(float(covariance(bench.evolve(overrides))[2, 2]))

    return FloorTerms(
        alone({"base.vibration_ug": 0.0}),
        alone({"sensor.noise_density_n_rthz": 0.0}),
        bench.sensor.step_n / math.sqrt(12),
    )
