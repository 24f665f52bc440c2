"""What the experimenter's page is told of a trial: nothing that gives away condition, level or the right answer."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.experiments.delivered import force_of
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.respondent import Live

OPEN = ("trial", "block", "phase", "valid", "counted", "again", "repeat_of")
"""Columns that everybody may see."""
SECRET = ("condition", "requested", "delivered", "comparison", "correct", "response", "method_state")
"""Columns that are shown without blinding alone."""
POINTS = 150
"""Points of a trace on the page (assumed)."""
MOST_MN = 100.0
"""Largest error that is told blind: before the finger slides the error is the set-point itself (assumed)."""


def told_of(row: Mapping[str, Any], protocol: Protocol) -> dict[str, Any]:
    """Return of a row what the page may show; blind, the reason is without its number and interval."""
    found = {name: row[name] for name in OPEN}
    found["rt_s"] = finite(row["rt_s"])
    found["reason"] = row["reason"] if not protocol.blind else reason(row["reason"])
    if not protocol.blind:
        found |= {name: finite(row[name]) for name in SECRET}
    return found


def reason(text: str) -> str:
    """Return a reason without numbers and intervals, each part once."""
    plain = re.sub(r"=[^ ;]*| in \d", "", text)
    return "; ".join(dict.fromkeys(plain.split("; "))).replace("_", " ")


def live_of(sample: Live, blind: bool) -> dict[str, Any]:
    """Return a sample for the page; blind, the force is told beside its set-point alone."""
    found = {
        "interval": sample.interval,
        "at_s": round(sample.elapsed_s, 3),
        "error_mn": finite(round(_clipped(1e3 * (sample.force_n - sample.setpoint_n)), 2)),
        "speed_mm_s": finite(round(sample.speed_mm_s, 2)),
        "load_n": finite(round(sample.load_n, 3)),
    }
    return found if blind else found | {"force_n": finite(sample.force_n), "setpoint_n": finite(sample.setpoint_n)}


def trace_of(run: xr.Dataset, interval: int, duration_s: float, blind: bool) -> dict[str, Any]:
    """Return a stroke that is over as a trace for the page; blind, the error where it is scored, within limits."""
    every = max(run.sizes["time"] // POINTS, 1)
    part = run.isel(time=slice(None, None, every))
    force, setpoint = part[force_of(part)].values, part["f_r"].values
    error = np.where(part["scored"].values, np.clip(1e3 * (force - setpoint), -MOST_MN, MOST_MN), np.nan)
    lines = {"error_mn": error} if blind else {"force_n": force, "setpoint_n": setpoint}
    found = {name: [finite(round(float(each), 4)) for each in values] for name, values in lines.items()}
    return {"interval": interval, "duration_s": duration_s, **found}


def _clipped(error_mn: float) -> float:
    return min(max(error_mn, -MOST_MN), MOST_MN)


def finite(value: Any) -> Any:
    """Return a value, None in place of what is no number: JSON has no NaN."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
