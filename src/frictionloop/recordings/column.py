"""A column of a file as it was found: its samples, where each stands, and how it is refused when it is not there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionloop.parameters.sources import Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.headers import header

Array = NDArray[np.float64]
DEFAULT = "(the default of --disturbance.column and --setpoint.column)"
SHOWN = 20
"""Names listed in an error."""


@dataclass(frozen=True)
class Column:
    """One column of a file, not yet cut or scaled."""

    samples: NDArray[Any]
    place: Callable[[int], str]
    """How the file calls sample i, and what stands there."""
    name: str = ""
    """What the file calls it."""
    unit: str | None = None
    """What the file says."""
    unit_in_doubt: str = ""
    """Why a unit in the file is not taken, to be refused where none is given."""
    rate_hz: float | None = None
    """Sampling rate that the format, an attribute or a number beside it says."""
    rate_by: str = ""
    """What says it."""
    full_scale: bool = False
    """Whether the format has a full scale in the place of a unit."""
    path: str = ""
    """Its name with the groups that it stands in."""
    times: Column | None = None
    """The column of times beside it."""
    others: Sequence[str] = ()
    """What else in the file may be a force."""
    head: str = ""
    """Where the file has names and units, in words."""


def no_column(recording: Recording, there: list[str], why: str = "is not there") -> FrictionloopError:
    """Return the error that a column is not there, listing what is."""
    shown = ", ".join(there[:SHOWN]) + (f" and {len(there) - SHOWN} more" if len(there) > SHOWN else "")
    return FrictionloopError(
        f"{recording.path}: column = {recording.column!r} {why}; accepted: {shown or 'nothing in this file'}"
    )


def refuse_gaps(
    path: str,
    values: Array,
    place: Callable[[int], str],
    where: str = "",
    cut: str = "",
    accepted: str = "a finite number",
) -> None:
    """Refuse a NaN or an infinity, naming the first and where it stands, where all are, and what cuts them out."""
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        more = f" (and {bad.size - 1} more)" if bad.size > 1 else ""
        raise FrictionloopError(f"{path}: {place(bad[0])}{more}{where}; accepted: {accepted}{cut}")


def column_number(recording: Recording, names: list[str], count: int, head: str = "") -> int:
    """Return the number of the column that is asked for by name, with or without its unit or quotes, or by number.

    ``head`` says where in the file the names stand.
    """
    column = recording.column.strip().strip("\"'").strip()
    name, unit = _plain(column)
    for found in (
        [k for k, there in enumerate(names) if there == column],
        [k for k, there in enumerate(names) if header(there).name == column],
        [k for k, there in enumerate(names) if _plain(there)[0] == name and unit in ("", _plain(there)[1])],
    ):
        if len(found) > 1:
            raise no_column(recording, list(map(str, found)), "is there more than once")
        if found:
            return found[0]
    if column.isdecimal() and int(column) < count:
        return int(column)
    there = [*map(repr, filter(None, names)), f"a number from 0 to {count - 1}"]
    raise no_column(recording, there, f"is not there ({head})" if head else "is not there")


def _plain(text: str) -> tuple[str, str]:
    """Return the name and the unit of a header as people copy them: in any case, with any brackets."""
    found = header(text)
    return " ".join(found.name.split()).casefold(), (found.unit or "").casefold()
