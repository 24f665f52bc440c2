"""What one entry of a project told: measured values, sentences, a table, and what the certificate draws."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.identification.channels import READING
from frictionloop.identification.measured import Measured, measured
from frictionloop.identification.mode import Modes
from frictionloop.identification.project import Take
from frictionloop.quantities import FrictionloopError

POINTS = 600
"""Points of a curve that is drawn."""


@dataclass(frozen=True)
class Sensor:
    """What is known of the sensor when the next recording is analysed."""

    sensitivity: float = 1.0
    unit: str = "N"
    resonance_hz: float | None = None
    cutoff_hz: float | None = None
    cutoff_error_hz: float = 0.0


@dataclass(frozen=True)
class Part:
    """What one entry of the project told."""

    kind: str
    files: tuple[dict[str, str], ...]
    """path, sha256, date of each."""
    measured: tuple[Measured, ...]
    told: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    """A table, its first row the heading."""
    curves: dict[str, Any]
    """What is drawn."""


def in_newtons(run: xr.Dataset, sensor: Sensor) -> tuple[xr.Dataset, list[str]]:
    """Return a recording with its reading in newtons, and what is said of how.

    By the weights of the project; where these were read in another unit or there are none, by what the map says.
    """
    reading = run[READING]
    unit, stated = reading.attrs.get("units"), reading.attrs.get("newtons_per_unit")
    told = []
    if unit == sensor.unit:
        factor = 1 / sensor.sensitivity
    elif stated is not None:
        factor = float(stated)
        told.append(f"{READING} is in newtons by the channel map, {factor:.4g} N per {unit}, and not by weights")
    else:
        factor = 1.0
        if unit != "N":
            told.append(f"{READING} is in {unit}, and no weights in {unit} tell newtons: 1 {unit} is taken for 1 N")
    return run.assign({READING: (factor * reading).assign_attrs({"units": "N"})}), told


Rows = list[tuple[str, ...]]
Found = tuple[list[Measured], list[str], Rows, dict[str, Any]]


def with_method(error: float, apart: float) -> float:
    """Return the error of a method whose value is so far from another method's."""
    return float(np.hypot(error, apart / np.sqrt(3)))


def thin(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[list[float], list[float]]:
    """Return a curve by at most so many points, evenly on a logarithmic axis."""
    if x.size <= POINTS:
        return x.tolist(), y.tolist()
    rows = np.unique(np.searchsorted(x, np.geomspace(x[0], x[-1], POINTS)).clip(0, x.size - 1))
    return x[rows].tolist(), y[rows].tolist()


def extra_modes(take: Take, found: Modes, how: str, date: str) -> list[Measured]:
    """Return frequency and Q of as many modes as an entry wants listed, under names of their own."""
    if take.count is None:
        return []
    listed = found.modes[: take.count]
    values: list[Measured] = []
    for k, mode in enumerate(listed):
        shifts = [found.method_hz[k]], [found.method_q[k]]
        values.append(measured(f"mode {k + 1}", [mode.frequency], shifts[0], how, take.files, date))
        values.append(measured(f"mode {k + 1} Q", [mode.q], shifts[1], how, take.files, date))
    if len(listed) < take.count:
        raise FrictionloopError(f"count = {take.count}: there are {len(listed)} modes; accepted: at most so many")
    return values
