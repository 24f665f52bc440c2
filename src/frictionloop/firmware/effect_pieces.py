"""Tables of an effect with as few values as they need: what the store of a device has room for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

TOLERANCE_N = 5e-5
"""Difference from the simulator's table at which no more values are spent (assumed: a quarter of the 0.2 mN that C and
Python may differ by)."""
GROWTH = 1.2
"""From one number of values that is tried to the next."""


class Piece(NamedTuple):
    """A table over place (mm) or over time (s)."""

    values: np.ndarray
    """Forces in N; of one that repeats, the first again at the end."""
    start: float
    per: float
    """Values per mm, or per s."""
    nearest: bool = False
    repeats: bool = False

    @property
    def values_count(self) -> int:
        """Values without the one that closes a period."""
        return len(self.values) - self.repeats

    @property
    def least(self) -> int:
        """The fewest values it can have."""
        return 2

    def trimmed(self, reach: float) -> Piece:
        """Return it without values beyond a distance from 0, nor those that only hold an end."""
        if self.repeats or self.nearest:
            return self
        at = self.start + np.arange(len(self.values)) / self.per
        moves = np.flatnonzero(np.diff(self.values))
        first, last = (moves[0], moves[-1] + 1) if moves.size else (0, 1)
        first = max(first, int(np.searchsorted(at, -reach, "right")) - 1)
        last = min(last, int(np.searchsorted(at, reach)))
        first = min(first, len(at) - 2)
        last = max(last, first + 1)
        return self._replace(values=self.values[first : last + 1], start=float(at[first]))

    def resampled(self, size: int) -> Piece:
        """Return it with so many values in all; as it is where it has no more."""
        if size >= len(self.values):
            return self
        at = np.linspace(0.0, len(self.values) - 1.0, size)
        values = self.values[np.rint(at).astype(int)] if self.nearest else self._at(at)
        return self._replace(values=values, per=self.per * (size - 1.0) / (len(self.values) - 1.0))

    def error_n(self, size: int) -> float:
        """Return the largest difference that so many values make."""
        few = self.resampled(size)
        at = np.arange(len(self.values)) * (few.per / self.per)
        if self.nearest:
            return float(np.max(np.abs(few.values[np.floor(at + 0.5).astype(int)] - self.values)))
        return float(np.max(np.abs(np.interp(at, np.arange(size), few.values) - self.values)))

    def needs(self, most: int) -> int:
        """Return the fewest values, at most so many, with which it differs by no more than the tolerance."""
        size = self.least
        while size < min(most, len(self.values)):
            if self.error_n(size) <= TOLERANCE_N:
                return size
            size = max(int(size * GROWTH), size + 1)
        return min(most, len(self.values))

    def _at(self, at: np.ndarray) -> np.ndarray:
        return np.interp(at, np.arange(len(self.values)), self.values)


def shared(needs: Sequence[int], room: int) -> list[int]:
    """Return how many values each piece gets of a room: what it needs, or an even share of what the others leave."""
    given, left = [0] * len(needs), room
    for rank, k in enumerate(sorted(range(len(needs)), key=lambda k: needs[k])):
        given[k] = min(needs[k], left // (len(needs) - rank))
        left -= given[k]
    return given
