"""A recorded run as a Dataset in the form of `simulate`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.device.counted import counted
from frictionloop.device.pipe import Pipe
from frictionloop.device.recorder import CHANNELS, FLAGS, SCALES, TICK_HZ, Recorder, gaps
from frictionloop.loop.record import VARIABLES, provenance
from frictionloop.parameters import SCHEMA, System
from frictionloop.quantities.version import package_version

CLOCK_BITS = 32
TOLD = {"a": ("um", "amplitude command, zero-to-peak")}
"""What a device tells where a simulated run has what the plate does."""


def to_dataset(recorder: Recorder, rows: int, pipe: Pipe, system: System | None, attrs: dict[str, Any]) -> xr.Dataset:
    """Return the first rows of a recording; what is missing is NaN, not ``scored``, and counted in the attributes."""
    there, raw = recorder.recorded[:rows], recorder.raw[:rows]
    sliding = there & (raw[:, FLAGS] & 1 != 0)
    data: dict[str, xr.Variable] = {}
    for channel, name in enumerate(CHANNELS):
        if channel != FLAGS:
            data[name] = _variable(name, np.where(there, raw[:, channel] * SCALES[channel], np.nan))
    if (
        recorder.start_tick is not None
        and (felt := pipe.felt(recorder.start_tick, rows, recorder.decimation)) is not None
    ):
        data["f_a"] = _variable("f_a", felt)
    data["saturated"] = _variable("saturated", there & (raw[:, FLAGS] & 2 != 0))
    data["sliding"] = _variable("sliding", sliding)
    data["scored"] = _variable("scored", counted(sliding, data["position"].values, data["load"].values, system))
    time = np.arange(rows) * recorder.decimation / TICK_HZ
    missing = gaps(there)
    lost = {
        "lost_samples": sum(count for _, count in missing),
        "gaps": len(missing),
        "dropped_samples": recorder.dropped,
        "implausible_samples": recorder.implausible,
        "start_tick": -1 if recorder.start_tick is None else recorder.start_tick,
    }
    kept = provenance(system, source=pipe.source) if system else _without_system(pipe.source)
    return xr.Dataset(
        data, {"time": xr.Variable("time", time, {"units": "s", "long_name": "time"})}, kept | lost | attrs
    )


def clock_fit(pairs: list[tuple[int, float, float]]) -> dict[str, float]:
    """Return how the device's clock goes against the host's, from (device's us, host's s, round trip in s).

    device_s = clock_offset_s + clock_rate host_s, host_s from the first pair on, by least squares over the half of the
    pairs with the shortest round trips: what is late was held up on one way, and does not tell the time.
    """
    if len(pairs) < 4:
        return {"clock_rate": math.nan, "clock_offset_s": math.nan, "clock_residual_s": math.nan}
    device = np.unwrap([float(pair[0]) for pair in pairs], period=2.0**CLOCK_BITS) * 1e-6
    host, trip = np.array([pair[1:] for pair in pairs]).T
    host = host - host[0]
    best = np.argsort(trip, kind="stable")[: max(len(pairs) // 2, 2)]
    offset, rate = np.polynomial.Polynomial.fit(host[best], device[best], 1).convert().coef
    residual = device[best] - offset - rate * host[best]
    fit = {"clock_rate": rate, "clock_offset_s": offset, "clock_residual_s": np.sqrt(np.mean(residual**2))}
    return {name: float(value) for name, value in fit.items()}


def _variable(name: str, values: np.ndarray) -> xr.Variable:
    units, meaning = TOLD.get(name) or VARIABLES[name]
    return xr.Variable("time", values, {"units": units, "long_name": meaning})


def _without_system(source: str) -> dict[str, Any]:
    """Return the attributes of a device that was set up by hand: nobody knows which System that is."""
    return {"version": package_version(), "schema": SCHEMA, "source": source}
