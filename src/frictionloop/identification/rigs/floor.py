"""Rig (c): the sensor left alone (paper, Sec. 3.3 and Fig. 4b)."""

from __future__ import annotations

import xarray as xr

from frictionloop.identification.rigs.sensor import reading, spring_noise, to_dataset
from frictionloop.loop.timing import check_seed
from frictionloop.parameters.rigs import CalibrationBench
from frictionloop.quantities.checks import number

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
    rate_hz = number("rate_hz", rate_hz, "Hz", 1.0)
    duration_s = number("duration_s", duration_s, "s", 2 / rate_hz, _SECONDS)
    seed = check_seed(seed)
    noise_n = spring_noise(bench, round(duration_s * rate_hz), rate_hz, seed)
    return to_dataset(bench, "floor", seed, rate_hz, {"f_m": reading(bench, noise_n)})
