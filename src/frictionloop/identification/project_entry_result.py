"""What one entry of a project gave: measured values, numbers, findings, a table, what is drawn; and its refusal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.findings import Condition, Finding, shown
from frictionloop.identification.estimate import Estimate, Measured
from frictionloop.identification.recording_columns import READING, no_column
from frictionloop.quantities import Array, FrictionloopError

POINTS = 600
"""Points of a curve that is drawn."""
Rows = list[tuple[str, ...]]
Numbers = Mapping[str, Any]
"""Numbers by name: plain, a list of them, or an `Estimate`."""


@dataclass(frozen=True)
class Sensor:
    """What is known of the sensor when the next recording is analysed."""

    sensitivity: float = 1.0
    unit: str = "N"
    resonance_hz: float | None = None
    cutoff_hz: float | None = None
    cutoff_error_hz: float = 0.0
    share: float = 0.0
    """Relative standard error of the sensitivity."""

    def divided(self, each: Measured, runs: Sequence[xr.Dataset]) -> Measured:
        """Return a value in newtons with the error of the sensitivity that its readings were divided by."""
        by_weights = all(READING in run and run[READING].attrs.get("units") == self.unit for run in runs)
        if not (by_weights and each.unit.startswith("N")):
            return each
        return replace(each, method=float(np.hypot(each.method, self.share * each.value)))


@dataclass(frozen=True)
class EntryResult:
    """What an analysis gives of one entry of the project."""

    measured: Sequence[Measured]
    findings: Sequence[Finding]
    numbers: Numbers
    """What else was found, by name."""
    rows: Sequence[tuple[str, ...]]
    """A table, its first row the heading."""
    curves: Mapping[str, Any] = field(repr=False)
    """What is drawn."""
    kind: str = ""
    files: tuple[dict[str, str], ...] = ()
    """path, sha256, date of each."""

    def to_dict(self) -> dict[str, Any]:
        """Return all but what is drawn."""
        return {name: value for name, value in self.__dict__.items() if name != "curves"}


class Refused(FrictionloopError):
    """An analysis that does not return what its data cannot tell; the figure of its ``kind`` draws ``curves``."""

    def __init__(self, said: str, kind: str, curves: Mapping[str, Any]) -> None:
        super().__init__(said)
        self.kind = kind
        self.curves = dict(curves)


def pictured(refusal: FrictionloopError, said: str, kind: str, file: Path, rate_hz: float | None) -> Refused:
    """Return a refusal with what its analysis saw; where it had not got that far, with the channels of the file."""
    if isinstance(refusal, Refused) and refusal.curves:
        return Refused(said, kind, refusal.curves)
    return Refused(said, "recording", {"file": str(file), "rate_hz": rate_hz})


def number_said(value: Any) -> str:
    """Return a number as a person reads it, an `Estimate` with its interval, from plain data too."""
    if isinstance(value, Mapping):
        known = {**value, "freedom": np.inf if value["freedom"] is None else value["freedom"]}
        return str(Estimate(**known))
    return str(value) if isinstance(value, Estimate) else shown(value, 5)


def in_newtons(runs: Sequence[xr.Dataset], sensor: Sensor) -> tuple[list[xr.Dataset], list[Finding]]:
    """Return recordings with their readings in newtons, and what is in doubt of how.

    By the weights of the project; where these were read in another unit or there are none, by what the map says.
    """
    scaled, found = [], []
    for run in runs:
        if READING not in run:
            raise no_column(READING, run)
        reading = run[READING]
        unit, stated = reading.attrs.get("units"), reading.attrs.get("newtons_per_unit")
        if unit == sensor.unit:
            factor = 1 / sensor.sensitivity
        else:
            factor = 1.0 if stated is None else float(stated)
            if stated is not None or unit != "N":
                more = {"path": f"{READING}: 1 {unit} by weights"}
                found.append(Finding("TAKEN-FOR", value=factor, unit="N", more=more))
        scaled.append(run.assign({READING: (factor * reading).assign_attrs({"units": "N"})}))
    return scaled, found


def off_line(what: str, value: float, unit: str, name: str = "") -> Finding:
    """Return that a fit leaves something systematic."""
    return Finding("LINE-OFF", value=value, unit=unit, where=Condition(channel=name), more={"what": what})


def not_told(what: str, reason: str) -> Finding:
    """Return that recordings do not tell a value."""
    return Finding("NOT-TOLD", more={"what": what, "reason": reason})


def with_method(error: float, apart: float) -> float:
    """Return the error of a method whose value is so far from another method's."""
    return float(np.hypot(error, apart / np.sqrt(3)))


def thinned(points: int, **curves: Array) -> dict[str, list[float]]:
    """Return curves of one length of which every nth point is drawn, by name."""
    step = max(next(iter(curves.values())).size // points, 1)
    return {name: np.asarray(each)[::step].tolist() for name, each in curves.items()}


def log_rows(x: Array) -> NDArray[np.intp]:
    """Return the rows of at most so many points of a curve, evenly on a logarithmic axis."""
    if x.size <= POINTS:
        return np.arange(x.size)
    return np.unique(np.searchsorted(x, np.geomspace(x[0], x[-1], POINTS)).clip(0, x.size - 1))
