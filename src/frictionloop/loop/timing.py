"""How many control periods a run has, and whether it can be run at all."""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np

from frictionloop.parameters import System, check_system
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.checks import whole


def is_finite(value: Any) -> bool:
    """Return whether a value is one finite number (a bool is none)."""
    try:
        return not isinstance(value, (bool, np.bool_)) and math.isfinite(value)
    except (TypeError, OverflowError):
        return False


def periods_in(system: System, duration_s: float) -> int:
    """Return the number of control periods in ``duration_s``, a whole number of them.

    Raises ``FrictionloopError`` when the duration is not positive, not whole, or longer than a swept signal.
    """
    check_system(system)
    rate = system.controller.rate_hz
    if not (is_finite(duration_s) and duration_s > 0):
        raise must_be("duration_s", duration_s, "a positive number", "s")
    if duration_s * rate > 2**53:
        raise FrictionloopError(f"duration_s = {duration_s:g} s: is too long")
    periods = round(duration_s * rate)
    if periods < 1 or abs(periods - duration_s * rate) > 1e-6 * max(periods, 1):
        near = max(periods, 1) / rate
        raise FrictionloopError(
            f"duration_s = {duration_s} s: no whole number of periods at controller.rate_hz = {rate:g} Hz; "
            f"nearest: {near} s"
        )
    for name in ("setpoint", "disturbance"):
        source = getattr(system, name)
        longest, field = source.longest_s, "sweep_s" if source.kind == "log_sweep" else "longest_s"
        if duration_s > longest * (1 + 1e-12):
            cure = f"; accepted: {name}.sweep_s = {duration_s:g}, or --{name}.kind constant"
            raise FrictionloopError(
                f"duration_s = {duration_s:g} s runs past the end of {name}.{field} = {longest:g} s"
                + (cure if field == "sweep_s" else "")
            )
    return periods


def check_seed(seed: Any) -> int:
    """Return a seed of the noise, refusing what is not a whole number of 64 bits."""
    return whole("seed", seed, 0, 2**64 - 1)


def check_memory(needed_bytes: int, what: str) -> None:
    """Refuse work that would not fit into this machine's free memory, saying how much it needs."""
    try:
        free = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (ValueError, OSError, AttributeError):  # not every system tells
        return
    if needed_bytes > free:
        raise FrictionloopError(
            f"{what}: {needed_bytes / 1e9:.1f} GB of memory, {free / 1e9:.1f} GB free; shorten duration_s or sweep()"
        )
