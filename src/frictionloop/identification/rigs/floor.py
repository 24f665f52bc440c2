"""Rig (c): the sensor left alone, and what its noise should come to (paper, Sec. 3.3 and Fig. 4b)."""

from __future__ import annotations

import math
from typing import NamedTuple

import xarray as xr

from frictionloop.identification.rigs.sensor import checked, checked_seed, covariance, reading, spring_noise, to_dataset
from frictionloop.parameters.rigs import CalibrationBench
from frictionloop.quantities import FrictionloopError

_SECONDS = 36000.0  # ten hours: what fits in memory at 5 kHz


def floor_rig(
    bench: CalibrationBench | None = None, duration_s: float = 10.0, rate_hz: float = 5000.0, seed: int = 0
) -> xr.Dataset:
    """Return the recording of the sensor without a finger: ``f_m`` in N over ``time`` in s.

    White noise of the electronics behind the pole, acceleration of the base times the moving mass through the
    suspension, offset and converter, all stationary from the first sample (rig_sensor).

    Parameters
    ----------
    bench : CalibrationBench, optional
        Sensor and base; None is the default bench.
    duration_s : float
        Length in s; 10 in the paper.
    rate_hz : float
        Samples per second; what lies above half of it folds down, as it does without an anti-alias filter.
    seed : int
        Seed of the noise.

    Raises
    ------
    FrictionloopError
        For a number out of range.

    Notes
    -----
    Source: paper, Sec. 3.3.
    """
    bench = bench or CalibrationBench()
    rate_hz = checked("rate_hz", rate_hz, "Hz", 1.0)
    duration_s = checked("duration_s", duration_s, "s", 2 / rate_hz, _SECONDS)
    seed = checked_seed(seed)
    noise_n = spring_noise(bench, round(duration_s * rate_hz), rate_hz, seed)
    return to_dataset(bench, "floor", seed, rate_hz, {"f_m": reading(bench, noise_n)})


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


def floor_terms(bench: CalibrationBench | None = None) -> FloorTerms:
    """Return what the noise should come to, from the covariance of the sensor's equations in closed form."""
    bench = bench or CalibrationBench()

    def alone(overrides: dict[str, float]) -> float:
        return math.sqrt(float(covariance(bench.evolve(overrides))[2, 2]))

    return FloorTerms(
        alone({"base.vibration_ug": 0.0}),
        alone({"sensor.noise_density_n_rthz": 0.0}),
        bench.sensor.step_n / math.sqrt(12),
    )


def vibration_allowed_ug(floor_n: float = 5e-5, bench: CalibrationBench | None = None) -> float:
    """Return the vibration of the base, 1e-6 g rms, with which electronics and base together stay at ``floor_n``.

    Parameters
    ----------
    floor_n : float
        Standard deviation of the reading in N; 5e-5 in the paper (Sec. 3.3).
    bench : CalibrationBench, optional
        Sensor and corner of the base's vibration.

    Raises
    ------
    FrictionloopError
        For a floor that the electronics alone exceed.
    """
    bench = (bench or CalibrationBench()).evolve({"base.vibration_ug": 1.0})
    terms = floor_terms(bench)
    if not floor_n >= terms.electronics_n:
        raise FrictionloopError(
            f"floor_n = {floor_n:g} N: must be at least {terms.electronics_n:.3g}, what the electronics alone make"
        )
    return math.sqrt(floor_n**2 - terms.electronics_n**2) / terms.base_n
