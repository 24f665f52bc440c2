"""Whether a limit observer was within what it states of a finger: the law again, along what a run recorded.

It states how far readings move the logarithm of its limit (`STATED` of control/limit_step), and within which bounds
the susceptibility is. Beyond the first it goes back to where learning begins, beyond the second it stays at the bound.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.control.law import switched_clamp
from frictionloop.control.laws import law_of
from frictionloop.control.limit_step import LEAST_SWING, STATED, LimitGains, LimitState
from frictionloop.loop.record import system_of
from frictionloop.sensing.measurement import Measurement

NEAR = 0.05
"""Share by which a bound is at hand: what is learnt moves about it by as much (assumed)."""


class Beyond(NamedTuple):
    """Shares of the time, 0 to 1."""

    surprised: float
    """Readings moved the limit by more than is stated."""
    bound: float
    """What the set-point teaches is at a bound; also for some tenths of a second while it comes from there."""


def beyond(run: xr.Dataset) -> Beyond | None:
    """Return how much of a run's time its limit observer was beyond what it states; None under another law.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate`` or ``load``: ``f_m``, ``speed``, ``sliding`` and ``f_r`` are gone along. The law had the
        speed of its position sensor, which lags by some ms.

    Raises
    ------
    FrictionloopError
        For a run without its System.
    """
    controller: Any = system_of(run).controller
    if controller.kind != "limit_observer" or "speed" not in run:
        return None
    surprised = bound = 0
    for gains, state in _along(run, controller):
        if state.misfit > STATED**2:
            surprised += 1
        elif gains.spread > 1.0 and state.swing > LEAST_SWING**2:
            off = state.fall / gains.model_fall
            bound += not (1.0 + NEAR) / gains.spread < off < gains.spread * (1.0 - NEAR)
    return Beyond(surprised / run.sizes["time"], bound / run.sizes["time"])


def _along(run: xr.Dataset, controller: Any) -> Iterator[tuple[LimitGains, LimitState]]:
    law, dt = law_of(controller), 1.0 / controller.rate_hz
    gains, state = law.gains_for(controller), law.start_for(controller)
    opened = round(controller.open_until_s * controller.rate_hz)
    columns = (run[name].values.astype(np.float64).tolist() for name in ("f_m", "speed", "sliding", "f_r"))
    for k, (force, speed, sliding, wanted) in enumerate(zip(*columns, strict=True)):
        low, high = switched_clamp(wanted, gains.low, gains.high, k - opened) if opened else gains[-2:]
        now = gains._replace(low=low, high=high)
        state, _ = law.step(state, Measurement(force, 0.0, speed, 0.0, sliding), wanted, now, dt)
        yield gains, state
