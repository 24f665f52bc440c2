"""What one entry of a project told: measured values, numbers, findings, a table, and what the certificate draws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.findings import Condition, Finding, shown
from frictionloop.identification.measured import Estimate, Measured, measured
from frictionloop.identification.modes import Modes
from frictionloop.identification.project import Take
from frictionloop.identification.recording_columns import READING
from frictionloop.quantities import must_be

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


Rows = list[tuple[str, ...]]
Numbers = Mapping[str, Any]
"""Numbers by name: plain, a list of them, or an `Estimate`."""


class Told(NamedTuple):
    """What an analysis gives of an entry."""

    measured: Sequence[Measured]
    findings: Sequence[Finding]
    numbers: Numbers
    rows: Rows
    """A table, its first row the heading."""
    curves: dict[str, Any]
    """What is drawn."""


@dataclass(frozen=True)
class Part:
    """What one entry of the project told."""

    kind: str
    files: tuple[dict[str, str], ...]
    """path, sha256, date of each."""
    measured: tuple[Measured, ...]
    findings: tuple[Finding, ...]
    numbers: Numbers
    """What else was found, by name."""
    rows: tuple[tuple[str, ...], ...]
    curves: dict[str, Any] = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """Return all but what is drawn."""
        return {name: value for name, value in self.__dict__.items() if name != "curves"}


def number_said(value: Any) -> str:
    """Return a number as a person reads it, an `Estimate` with its interval, from plain data too."""
    if isinstance(value, Mapping):
        known = {**value, "freedom": np.inf if value["freedom"] is None else value["freedom"]}
        return str(Estimate(**known))
    return str(value) if isinstance(value, Estimate) else shown(value, 5)


def in_newtons(run: xr.Dataset, sensor: Sensor) -> tuple[xr.Dataset, list[Finding]]:
    """Return a recording with its reading in newtons, and what is in doubt of how.

    By the weights of the project; where these were read in another unit or there are none, by what the map says.
    """
    reading = run[READING]
    unit, stated = reading.attrs.get("units"), reading.attrs.get("newtons_per_unit")
    found = []
    if unit == sensor.unit:
        factor = 1 / sensor.sensitivity
    else:
        factor = 1.0 if stated is None else float(stated)
        if stated is not None or unit != "N":
            found = [Finding("TAKEN-FOR", value=factor, unit="N", more={"path": f"{READING}: 1 {unit} by weights"})]
    return run.assign({READING: (factor * reading).assign_attrs({"units": "N"})}), found


def off_line(what: str, value: float, unit: str, name: str = "") -> Finding:
    """Return that a fit leaves something systematic."""
    return Finding("LINE-OFF", value=value, unit=unit, where=Condition(channel=name), more={"what": what})


def not_told(what: str, reason: str) -> Finding:
    """Return that recordings do not tell a value."""
    return Finding("NOT-TOLD", more={"what": what, "reason": reason})


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
    if len(listed) < take.count:
        raise must_be("count", take.count, f"at most {len(listed)}, the modes found")
    values: list[Measured] = []
    for k, mode in enumerate(listed):
        shifts = [found.method_hz[k]], [found.method_q[k]]
        values.append(measured(f"mode {k + 1}", [mode.frequency], shifts[0], how, take.files, date))
        values.append(measured(f"mode {k + 1} Q", [mode.q], shifts[1], how, take.files, date))
    return values
