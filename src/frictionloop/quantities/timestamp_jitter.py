"""What is uneven in a column of times: rows that are missing, rows that go back, and the jitter of the others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

MISSING = 1.75
"""Steps, in usual ones, from which on rows are missing: two less a quarter, which is left to jitter (chosen)."""
SHOWN = 5
"""Gaps that are listed."""
Place = Callable[[int], str]
"""Tells where a row stands and what is there: "line 7: t is '10'", "column 't' at index 5 is 10"."""


class Uneven(NamedTuple):
    """What is uneven; each index is that of the row after the step."""

    missing: tuple[tuple[int, int], ...]
    """Rows behind a gap, and how many rows are missing before them."""
    back: tuple[int, ...]
    """Rows that are no later than those before."""
    blank: tuple[int, ...]
    """Rows without a time."""
    jitter: float
    """Largest deviation of all other steps from the usual one, as a share of it; 0 if they are even."""
    latest: int
    """The row behind that step."""

    def describe(self, place: Place) -> str:
        """Return it in words: gaps first, then rows that go back or have no time, and jitter as one figure."""
        gaps = [f"{count} before {_line(place(k))}" for k, count in self.missing]
        said = [
            _listed("rows missing in the times: ", gaps),
            _listed("times no later than the row before: ", [place(k) for k in self.back[:1]], len(self.back)),
            _listed("no time: ", [place(k) for k in self.blank[:1]], len(self.blank)),
        ]
        if self.jitter:
            said.append(f"steps up to {100 * self.jitter:.2g} % off, most before {_line(place(self.latest))}")
        return "; ".join(filter(None, said))


def uneven_in(in_s: NDArray[np.float64], usual_s: float, even: float) -> Uneven | None:
    """Return what is uneven in times, None if all steps are within a share ``even`` of the usual one.

    Parameters
    ----------
    in_s
        Times in s, NaN where there is none.
    usual_s
        The step between rows that most have, above 0.
    even
        Deviation of a step that counts as none, as a share.
    """
    steps = np.diff(in_s) / usual_s
    known = np.isfinite(steps)
    back, far = known & (steps <= 0), known & (steps >= MISSING)
    off = np.where(known & ~back & ~far, np.abs(steps - 1), 0.0)
    latest = int(off.argmax()) + 1
    jitter = float(off[latest - 1]) if off[latest - 1] > even else 0.0
    missing = tuple((int(k) + 1, round(float(steps[k])) - 1) for k in np.flatnonzero(far))
    found = Uneven(missing, _rows(back, 1), _rows(~np.isfinite(in_s)), jitter, latest)
    return found if missing or found.back or found.blank or jitter else None


def _rows(there: NDArray[np.bool_], after: int = 0) -> tuple[int, ...]:
    return tuple((np.flatnonzero(there) + after).tolist())


def _listed(what: str, places: Sequence[str], count: int | None = None) -> str:
    """Return the first places of all, and how many more there are; "" without any."""
    more = (len(places) if count is None else count) - min(len(places), SHOWN)
    return f"{what}{', '.join(places[:SHOWN])}{f' and {more} more' if more else ''}" if places else ""


def _line(place: str) -> str:
    """Return where a row stands, without what is there."""
    return place.partition(": ")[0].partition(" is ")[0]
