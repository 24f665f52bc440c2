"""The last seconds of a live session as a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from frictionloop.device.live_engine import CHANNELS
from frictionloop.device.live_session import KEPT_S, Session
from frictionloop.loop.record import VARIABLES, provenance

if TYPE_CHECKING:
    import xarray as xr

RUN = {
    "f_r": "asked_n",
    "f_a": "closed_n",
    "f_m": "measured_n",
    "a": "closed_um",
    "saturated": "saturated",
    "load": "load_n",
    "limit": "limit_n",
    "floor": "floor_n",
}
"""Variables of a run by the channel that holds them."""
BESIDE = {"f_a_open": "open_n", "a_open": "open_um"}
"""What the loop beside it adds, which is open."""


def recorded(session: Session, seconds: float = KEPT_S) -> xr.Dataset:
    """Return what a session keeps as a run that ``fl.save`` writes and ``fl.load`` reads.

    The variables are those of ``fl.simulate``, in float32; ``f_a_open`` and ``a_open`` are of the open loop beside it.
    The System is the one now in force: ``changed_at_s`` tells when it last changed.

    Parameters
    ----------
    session : Session
        What ran.
    seconds : float
        How much of it, s, at most `KEPT_S`.
    """
    import xarray as xr

    rows, rate = session.last(seconds), session.engine.rate_hz
    told = dict(zip(CHANNELS, rows, strict=True))
    first = session.ticks - rows.shape[1]
    time = np.arange(rows.shape[1]) / rate
    data = {
        name: xr.Variable("time", told[channel] != 0 if name == "saturated" else told[channel], _attrs(name, channel))
        for name, channel in {**RUN, **BESIDE}.items()
    }
    data["position"] = xr.Variable("time", 1e-3 * told["x_mm"], _attrs("position", "x_mm"))
    coordinate = {"time": xr.Variable("time", time, {"units": "s", "long_name": "time"})}
    more = {"began_at_s": first / rate, "changed_at_s": session.changed_tick / rate}
    return xr.Dataset(data, coordinate, provenance(session.engine.system, **more) | {"source": session.engine.source})


def _attrs(name: str, channel: str) -> dict[str, str]:
    units, meaning = VARIABLES.get(name, CHANNELS[channel])
    return {"units": units, "long_name": meaning}
