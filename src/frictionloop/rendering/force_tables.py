"""The primitives that are tables: a force over place (`Map`), a force over time (`Wave`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Field

from frictionloop.parameters.block import Number, Positive
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.outside_errors import place, theirs
from frictionloop.rendering.effect import Effect, Touch

MOST_CELLS = 32768
"""Cells of a map: what a file of parameters has room for (assumed); a larger one is reduced before it is one."""

BETWEEN = (0.5, 0.381966, 0.145898)
"""Where a map is compared with its function between two values: the middle, and two parts of the golden section."""


def _listed(values: Any) -> Any:
    return values.tolist() if isinstance(values, np.ndarray) else values


def _rows(values: Any) -> Any:
    """Return one row of numbers as a table of one row."""
    values = _listed(values)
    if isinstance(values, (list, tuple)) and values and not isinstance(values[0], (list, tuple, np.ndarray)):
        return [values]
    return values


class Map(Effect):
    """Force over place: a table of values a pitch apart, over x, or over x and y."""

    kind: Literal["map"] = "map"
    values_n: Annotated[tuple[tuple[Number, ...], ...], BeforeValidator(_rows), Field(min_length=1)]
    """Forces: a row over x, or rows over y of values over x, that of the largest y last."""
    pitch_mm: Positive
    """Distance from value to value, along x and along y."""
    start_mm: Number = 0.0
    """Where the first value is along x."""
    start_y_mm: Number = 0.0
    """Where the first row is along y."""
    between: Literal["linear", "nearest"] = "linear"
    """What is asked for between values: on the line between them, or the nearest."""
    beyond: Literal["hold", "repeat"] = "hold"
    """What is asked for beyond the edge: its value goes on, or the map begins anew, a pitch after the last value."""

    def _check(self) -> None:
        widths = {len(row) for row in self.values_n}
        if len(widths) != 1 or min(widths) < 2:
            raise must_be("values_n: lengths of rows", sorted(widths), "equal, 2 or more")
        if (cells := len(self.values_n) * widths.pop()) > MOST_CELLS:
            raise must_be("values_n", cells, f"at most {MOST_CELLS}", "values")

    @property
    def table(self) -> np.ndarray:
        """The values, shape (rows, columns)."""
        return np.array(self.values_n)

    @property
    def period_mm(self) -> float | None:
        """The width of a map that repeats."""
        return len(self.values_n[0]) * self.pitch_mm if self.beyond == "repeat" else None

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        table = self.table
        columns = _cells((np.asarray(touch.x_mm, float) - self.start_mm) / self.pitch_mm, table.shape[1], self)
        rows = _cells((np.asarray(touch.y_mm, float) - self.start_y_mm) / self.pitch_mm, table.shape[0], self)
        lower = _between(table[rows.cell, columns.cell], table[rows.cell, columns.after], columns.share)
        upper = _between(table[rows.after, columns.cell], table[rows.after, columns.after], columns.share)
        return _between(lower, upper, rows.share)


class _Cells(NamedTuple):
    cell: np.ndarray
    after: np.ndarray
    share: np.ndarray


def _between(here: Any, there: Any, share: Any) -> Any:
    return here + share * (there - here)


def _cells(u: np.ndarray, count: int, of: Map) -> _Cells:
    """Return the values on both sides of a place counted in pitches, and how far it is from one to the other."""
    if of.beyond == "repeat":
        u = u - count * np.floor(u / count)
    else:
        u = np.clip(u, 0.0, count - 1.0)
    if of.between == "nearest":
        u = np.floor(u + 0.5)
    cell = np.floor(u)
    after = cell + 1.0
    after = after % count if of.beyond == "repeat" else np.minimum(after, count - 1.0)
    return _Cells((cell % count).astype(int), after.astype(int), u - cell)


class Wave(Effect):
    """Force over time since it began: a table of values; 0 N before it and after its end."""

    kind: Literal["wave"] = "wave"
    values_n: Annotated[tuple[Number, ...], BeforeValidator(_listed), Field(min_length=2, max_length=MOST_CELLS)]
    """Forces."""
    rate_hz: Positive
    """Values per second; linear between them."""
    loops: bool = False
    """Whether it begins anew after its end."""

    @property
    def is_static(self) -> bool:
        """It depends on the time."""
        return False

    @property
    def duration_s(self) -> float:
        """Time from its first value to its end."""
        return (len(self.values_n) if self.loops else len(self.values_n) - 1) / self.rate_hz

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        values, time = np.array(self.values_n), np.asarray(touch.time_s, float)
        u, count = time * self.rate_hz, len(values)
        if self.loops:
            u = u - count * np.floor(u / count)
            values = np.append(values, values[0])
        forces = np.interp(u, np.arange(len(values)), values)
        return np.where((time >= 0.0) & (self.loops | (u <= count - 1)), forces, 0.0)


class Sampled(NamedTuple):
    """A map of a function of place, and how far it is from it."""

    map: Map
    error_n: float
    """Largest error at three places between each two values: midway, where lines are furthest from a smooth function,
    and where nothing that repeats after a pitch or a part of it hides."""


def sampled(force_n: Callable[[np.ndarray], Any], start_mm: float, stop_mm: float, pitch_mm: float) -> Sampled:
    """Return a function of place as a map, and the error that this makes.

    Parameters
    ----------
    force_n
        ``force_n(x_mm)``, given an array and returning the forces in N, of the same shape.
    start_mm, stop_mm
        From where to where, in mm.
    pitch_mm
        Distance from value to value in mm.

    Raises
    ------
    FrictionloopError
        For a function that raises, gives another shape or what is no finite number, or for a range without values.
    """
    if not (pitch_mm > 0 and stop_mm - start_mm >= pitch_mm and (stop_mm - start_mm) / pitch_mm < MOST_CELLS):
        raise FrictionloopError(f"pitch_mm = {pitch_mm!r} mm: must give 2 to {MOST_CELLS} values")
    x = start_mm + pitch_mm * np.arange(round((stop_mm - start_mm) / pitch_mm) + 1)
    values = _computed(force_n, x)
    errors = [
        _computed(force_n, x[:-1] + share * pitch_mm) - _between(values[:-1], values[1:], share) for share in BETWEEN
    ]
    return Sampled(Map(values_n=values, pitch_mm=pitch_mm, start_mm=start_mm), float(np.max(np.abs(errors))))


def _computed(force_n: Callable[[np.ndarray], Any], x: np.ndarray) -> np.ndarray:
    try:
        values = np.asarray(force_n(x), dtype=float)
    except Exception as error:
        raise theirs("function of place", force_n, error) from error
    if values.shape != x.shape:
        raise must_be(f"{place(force_n)}: returned shape", values.shape, f"that of x_mm, {x.shape}")
    if not np.all(np.isfinite(values)):
        wrong = int(np.flatnonzero(~np.isfinite(values))[0])
        raise must_be(f"{place(force_n)}: force_n at {x[wrong]:g} mm", float(values[wrong]), "finite")
    return values
