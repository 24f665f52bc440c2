"""How the plate's resonance drifts while it works, and what a carrier that stays loses by that."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.identification.estimate import Estimate
from frictionloop.identification.recording_columns import channel
from frictionloop.identification.straight_scale import straight_scale
from frictionloop.quantities import must_be

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CarrierDrift:
    """The drift of a resonance."""

    rate: Estimate
    """Hz per minute, a straight line over the whole time."""
    method_hz_per_min: float
    """Standard error of the method: how far the two halves are apart."""
    span_hz: float
    """Largest less least resonance."""
    per_kelvin: Estimate | None
    """Hz per kelvin, where the temperature was recorded."""
    time_s: Array
    frequency_hz: Array

    def share_left(self, resonance_hz: float, q: float) -> float:
        """Return the amplitude that a carrier at the one end keeps at the other: 1/sqrt(1 + (2 Q df/f0)^2)."""
        return 1 / math.hypot(1.0, 2 * q * self.span_hz / resonance_hz)


def carrier_drift(recording: xr.Dataset) -> CarrierDrift:
    """Return how a resonance that was tracked, or measured again and again, moves.

    Parameters
    ----------
    recording : xarray.Dataset
        ``frequency`` in Hz, and ``temperature`` in degC if known, over ``time`` in s; or a table with ``minutes``.

    Raises
    ------
    FrictionloopError
        For a column that is missing, fewer than four measurements, or times that are all alike.
    """
    dim = "row" if "row" in recording.dims else "time"
    frequency = channel(recording, "frequency", ("Hz",), dim=dim)
    if dim == "row":
        minutes = channel(recording, "minutes", ("min", "s", ""), dim=dim)
        minutes = minutes / 60 if recording["minutes"].attrs["units"] == "s" else minutes
    else:
        minutes = np.asarray(recording["time"].values, dtype=float) / 60
    if frequency.size < 4:
        raise must_be("recording: values of frequency", int(frequency.size), "at least 4")
    when, where = minutes, frequency
    # A tracked resonance wanders from sample to sample: means of a twentieth are taken for independent.
    if frequency.size > 40:
        when, where = (np.array([part.mean() for part in np.array_split(each, 20)]) for each in (minutes, frequency))
    line = straight_scale(when, where, "Hz/min")
    per_kelvin = None
    if "temperature" in recording:
        temperature = channel(recording, "temperature", ("degC", "K", ""), dim=dim)
        per_kelvin = straight_scale(temperature, frequency, "Hz/K").slope
    return CarrierDrift(
        line.slope, line.method, float(np.ptp(where)), per_kelvin, 60 * minutes, frequency,
    )  # fmt: skip
