"""Rig (e): known jumps at the controller's input, and the drive's answer on an oscilloscope."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from scipy.special import ndtr

from frictionloop.quantities.normals import normals

JUMP_STREAM = 33


def jumps_rig(
    delay_s: float = 200e-6,
    control_hz: float = 5000.0,
    plate_hz: float | None = 100.0,
    jumps: int = 12,
    rate_hz: float = 100e3,
    noise: float = 1e-3,
    waits: bool = True,
    seed: int = 0,
) -> xr.Dataset:
    """Return ``jump`` and ``answer`` in V over ``time``: steps of 1 V up and down, answered once they were sampled.

    The controller samples every 1/control_hz; a jump is answered ``delay_s`` after the first sample that sees it, by a
    step that the plate's low-pass rounds.

    Parameters
    ----------
    delay_s : float
        From the sample to the new command, in s.
    control_hz : float
        Control rate in Hz.
    plate_hz : float, optional
        Cutoff of the plate's envelope in Hz; None: the answer is the command itself.
    jumps : int
        Number of jumps.
    rate_hz : float
        Samples per second.
    noise : float
        Standard deviation of a sample of the answer in V (assumed).
    waits : bool
        Whether jumps come at any time of a control period; False: just before a sample.
    seed : int
        Seed of times and noise.
    """
    between = 0.04
    time = np.arange(round((jumps + 1) * between * rate_hz)) / rate_hz
    spread = ndtr(normals(seed, JUMP_STREAM, 0, jumps)) if waits else np.zeros(jumps)
    jump, answer = np.zeros_like(time), np.zeros_like(time)
    for k in range(jumps):
        begins = between * (k + 0.5) + spread[k] / control_hz
        sampled = math.ceil(begins * control_hz - 1e-9) / control_hz
        sign = 1 - 2 * (k % 2)
        jump += sign * (time >= begins)
        late = np.maximum(time - sampled - delay_s, 0.0)
        answer += sign * (late > 0 if plate_hz is None else -np.expm1(-2 * math.pi * plate_hz * late))
    answer += noise * normals(seed, JUMP_STREAM + 1, 0, time.size)
    units = {"units": "V"}
    return xr.Dataset(
        {"jump": ("time", jump, units), "answer": ("time", answer, units)},
        {"time": ("time", time, {"units": "s"})},
        {"source": "simulated"},
    )
