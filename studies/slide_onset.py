"""How a finger at rest begins to slide: the rise of friction, its peak, and the level that follows."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import xarray as xr

from studies.slide_window import window

SETTLED_S = 0.01
"""Time at rest that gives the force before the slip, and time left out after the peak (assumed)."""
KINETIC_S = 0.1
"""Time after the peak over which the kinetic level is taken (assumed)."""
ROUNDING = 1e-9
"""By how much, relative, a constant may exceed its own mean."""


class StickToSlip(NamedTuple):
    """What `stick_to_slip` gives."""

    peak_n: float
    """Largest friction of the window."""
    kinetic_n: float
    """Mean over ``KINETIC_S`` from ``SETTLED_S`` after the peak."""
    ratio: float
    """Peak over kinetic level."""
    fall_s: float
    """Time from the peak until the kinetic level is first reached."""
    fall_m: float
    """Way in that time."""
    rise_s: float
    """Time from 10 to 90 % of the way up from rest to the kinetic level."""
    travel_m: float
    """Way in that time."""
    stiffness_n_m: float
    """Force over way from 10 to 90 %."""


def stick_to_slip(recording: xr.Dataset, start_s: float, stop_s: float, friction: str = "f_a") -> StickToSlip:
    """Return how friction rises from rest, and how far above the level that follows."""
    beyond = SETTLED_S + KINETIC_S
    units = {friction: "N", "position": "m"}
    time, (f, x), rate_hz = window(recording, start_s, stop_s + beyond, units)
    skip = max(round(SETTLED_S * rate_hz), 1)
    rest, peak = float(f[:skip].mean()), int(np.argmax(f[: round((stop_s - start_s) * rate_hz)]))
    kinetic = float(f[peak + skip : peak + skip + round(KINETIC_S * rate_hz)].mean())
    low, high = (rest + share * (kinetic - rest) for share in (0.1, 0.9))
    begin, end = int(np.argmax(f >= low)), int(np.argmax(f >= high))
    fallen = peak + int(np.argmax(f[peak:] <= kinetic + ROUNDING * abs(kinetic)))
    travel_m = float(x[end] - x[begin])
    return StickToSlip(
        peak_n=float(f[peak]),
        kinetic_n=kinetic,
        ratio=float(f[peak]) / kinetic if kinetic > 0 else math.inf,
        fall_s=float(time[fallen] - time[peak]),
        fall_m=float(x[fallen] - x[peak]),
        rise_s=float(time[end] - time[begin]),
        travel_m=travel_m,
        stiffness_n_m=float(f[end] - f[begin]) / travel_m if travel_m > 0 else math.inf,
    )
