"""What is uneven in a column of times: rows that are missing, rows that go back, and the jitter of the others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

MISSING = 1.75
"""Steps, in usual ones, from which on rows are missing: two less a quarter, which is left to jitter (chosen)."""


class Uneven(NamedTuple):
    """The worst that is uneven."""

    kind: Literal["missing", "back", "blank", "off"]
    """Rows are missing, are no later than those before, have no time, or steps are off."""
    row: int
    """The first of them, and behind a step the one after it; of steps that are off, behind the worst."""
    rows: int
    """How many there are."""
    share: float = 0.0
    """Largest deviation of a step from the usual one, as a share of it."""

    def describe(self, place: Callable[[int], str]) -> str:
        """Return it in words; ``place`` tells where a row stands and what is there: "line 7: t is '10'"."""
        at = place(self.row)
        line = at.partition(": ")[0].partition(" is ")[0]
        return {
            "missing": f"rows missing in the times: {self.rows}, first before {line}",
            "back": f"times no later than the row before: {self.rows}, first {at}",
            "blank": f"no time: {self.rows}, first {at}",
            "off": f"steps up to {100 * self.share:.2g} % off, most before {line}",
        }[self.kind]


def uneven_in(in_s: NDArray[np.float64], usual_s: float, even: float) -> Uneven | None:
    """Return the worst that is uneven in times in s; None if all steps are within a share ``even`` of the usual one."""
    steps = np.diff(in_s) / usual_s
    known = np.isfinite(steps)
    back, far, blank = known & (steps <= 0), known & (steps >= MISSING), ~np.isfinite(in_s)
    if far.any():
        return Uneven("missing", int(far.argmax()) + 1, int(np.rint(steps[far] - 1).sum()))
    if back.any():
        return Uneven("back", int(back.argmax()) + 1, int(back.sum()))
    if blank.any():
        return Uneven("blank", int(blank.argmax()), int(blank.sum()))
    off = np.abs(steps - 1)
    if not (off > even).any():
        return None
    return Uneven("off", int(off.argmax()) + 1, int((off > even).sum()), float(off.max()))
