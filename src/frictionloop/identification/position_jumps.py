"""A position that jumps, as that of a counter which starts again."""

from __future__ import annotations

import numpy as np
import xarray as xr

JUMP = 0.25
"""A step of the position by more than this share of all its way is a jump (assumed)."""


def jumps_said(recording: xr.Dataset) -> list[str]:
    """Return in words that the position jumps, as that of a counter which starts again."""
    if "position" not in recording or "speed" in recording:
        return []
    position = recording["position"].values
    steps = np.abs(np.diff(position))
    row = int(np.argmax(steps))
    if steps[row] <= JUMP * float(np.ptp(position)):
        return []
    at = float(recording["time"][row])
    return [f"the position jumps at {at:.3f} s: if its counter starts again there, give wrap in the channel map"]
