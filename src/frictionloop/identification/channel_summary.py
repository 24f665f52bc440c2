"""A channel at a glance, block by block: its range, clipping, wraps, what is missing, and what is in doubt of it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionloop.findings import Condition, Finding
from frictionloop.identification.recording_columns import runs_of
from frictionloop.quantities import Array
from frictionloop.quantities.units import UNITS
from frictionloop.recordings.contents import Channel
from frictionloop.recordings.friction_defects import signs_of

SAMPLED = 20000
"""Samples from which the levels and the median of a channel are taken."""
FLAT_RUN = 4
"""Equal samples in a row at an end of the range that count as clipped (assumed: noise makes three)."""
LEVELS = 32
"""A channel with fewer different values is one of steps, such as masses, and does not clip (assumed)."""
RESTING = 0.1
"""An end as near to the median as this share of the range is where the channel rests (assumed)."""


class ChannelSummary(NamedTuple):
    """One channel at a glance."""

    name: str
    unit: str
    samples: int
    type: str
    least: float
    most: float
    rms: float
    """About its mean."""
    clipped: float
    """Share of the samples that stand at an end of the range in runs."""
    wraps: int
    """Jumps of a counter that starts again."""
    missing: int
    """Samples that are no finite number."""
    first_missing: int | None
    """Row of the first of these."""
    rate_hz: float | None
    both_signs: bool
    """Whether it looks like friction of strokes both ways; not known without a rate, or of another unit's numbers."""

    def findings(self) -> Iterator[Finding]:
        """Yield what is in doubt of the channel."""
        where = Condition(channel=self.name)
        if self.missing:
            yield Finding("DATA-GAPS", value=self.missing, where=where, more={"row": self.first_missing})
        if self.clipped:
            yield Finding("CLIPPED", value=100.0 * self.clipped, unit="%", where=where)
        if self.wraps:
            yield Finding("COUNTER-WRAPS", value=self.wraps, where=where, remedy="wrap in the map")
        if self.both_signs:
            ends = {"low": self.least, "high": self.most}
            yield Finding("SIGN-DOUBT", unit=self.unit, where=where, remedy="rectify", more=ends)


class Glance:
    """What is counted over the blocks of a channel: all of them go to `first`, then all of them to `second`."""

    def __init__(self, line: Channel) -> None:
        self.line = line
        self.least, self.most = np.inf, -np.inf
        self.count, self.mean, self.squares = 0, 0.0, 0.0
        self._every = max(line.samples.size // SAMPLED, 1)
        self._sampled: list[Array] = []
        self._at, self._inside = [0, 0], [0, 0]
        self._jumps, self._calm, self._last = 0, 0.0, np.zeros(0)
        self._whole, self._rows = True, 0
        self.bad: int | None = None
        self._levelled: bool | None = None

    @np.errstate(over="ignore", invalid="ignore")
    def first(self, block: NDArray[Any]) -> None:
        """Take a block in for the range, the mean and the levels."""
        fine = finite(block)
        if self.bad is None and fine.size < block.size:
            self.bad = self._rows + int(np.argmin(np.isfinite(block)))
        self._rows += block.size
        if not fine.size:
            return
        if not self.count:
            self._whole = bool(np.array_equal(fine[:1000], np.rint(fine[:1000])))
        self.least, self.most = min(self.least, float(fine.min())), max(self.most, float(fine.max()))
        mean, squares, count = float(fine.mean()), float(fine.var()) * fine.size, self.count + fine.size
        # Chan, Golub and LeVeque: sums of squares about means of parts, joined.
        self.squares += squares + (mean - self.mean) * (mean - self.mean) * self.count * fine.size / count
        self.mean += (mean - self.mean) * fine.size / count
        self.count = count
        self._sampled.append(fine[:: self._every].copy())

    @property
    def span(self) -> float:
        """Largest less least value."""
        return self.most - self.least if self.count else 0.0

    @np.errstate(over="ignore", invalid="ignore")
    def second(self, block: NDArray[Any]) -> None:
        """Take a block in for what the range is needed for: samples at its ends, and jumps over most of it."""
        fine, span = finite(block), self.span
        if span == 0 or not fine.size:
            return
        if self._levelled is None:
            self._levelled = np.unique(np.concatenate(self._sampled)).size < LEVELS
        if not self._levelled:
            for k, end in enumerate((self.most, self.least)):
                long, inside = at_end(fine, end, span)
                self._at[k] += int(np.count_nonzero(long))
                self._inside[k] += inside
        if span >= 128 and self._whole:
            steps = np.abs(np.diff(np.concatenate([self._last, fine])))
            jumps = steps > 0.5 * span
            self._jumps += int(np.count_nonzero(jumps))
            self._calm = max(self._calm, float(steps[~jumps].max(initial=0.0)))
            self._last = fine[-1:]

    @np.errstate(over="ignore", invalid="ignore")
    def result(self, rate_hz: float | None) -> ChannelSummary:
        """Return what was found; with the rate also what its signs say."""
        line, samples = self.line, self.line.samples
        wraps = self._jumps if self._calm < 0.05 * self.span else 0
        return ChannelSummary(
            name=line.name,
            unit=line.unit or "",
            samples=samples.size,
            type="complex" if samples.dtype.kind == "c" else str(samples.dtype),
            least=self.least if self.count else 0.0,
            most=self.most if self.count else 0.0,
            rms=float(np.sqrt(self.squares / self.count)) if self.count else 0.0,
            clipped=0.0 if wraps else self._clipped(),  # a counter that stands still
            wraps=wraps,
            missing=samples.size - self.count,
            first_missing=self.bad,
            rate_hz=rate_hz,
            both_signs=self._both_signs(rate_hz),
        )

    def _both_signs(self, rate_hz: float | None) -> bool:
        may_be_force = UNITS.get(self.line.unit or "N", ("",))[0] in ("N", "V") and not self.line.tells_time
        if rate_hz is None or not self.count or not may_be_force:
            return False
        return signs_of(np.concatenate(self._sampled), self.line.samples.size / rate_hz) == "both"

    def _clipped(self) -> float:
        if not self.span:
            return 0.0
        middle = float(np.median(np.concatenate(self._sampled)))
        found = 0
        for end, there, inside in zip((self.most, self.least), self._at, self._inside, strict=True):
            if abs(end - middle) >= RESTING * self.span and clips(there, inside, end, self.line.full_scale):
                found += there
        return found / self.count


def finite(block: NDArray[Any]) -> Array:
    """Return the samples that are finite numbers, magnitudes of complex ones."""
    real = np.abs(block) if block.dtype.kind == "c" else np.asarray(block, dtype=float)
    return np.asarray(real[np.isfinite(real)])


def clipped(values: Array) -> NDArray[np.bool_]:
    """Return which samples stand at the largest or the least value in runs of four or more.

    An end where a signal merely turns has more samples just inside it than at it; at one where it clips it is the other
    way round. A channel of few levels does not clip, nor does one at the value at which it rests.
    """
    at = np.zeros(values.size, dtype=bool)
    span = float(np.ptp(values)) if values.size else 0.0
    if span == 0 or np.unique(values[:: max(values.size // 20000, 1)]).size < LEVELS:
        return at
    middle = float(np.median(values))
    for end in (float(values.max()), float(values.min())):
        if abs(end - middle) < RESTING * span:
            continue
        long, inside = at_end(values, end, span)
        if clips(int(long.sum()), inside, end):
            at |= long
    return at


def clipped_share(values: Array) -> float:
    """Return the share of samples that are clipped."""
    return float(np.mean(clipped(values))) if values.size else 0.0


def at_end(values: Array, end: float, span: float) -> tuple[NDArray[np.bool_], int]:
    """Return which samples stand at an end of the range in runs, and how many are within a hundredth of it."""
    near = np.abs(values - end) <= 1e-9 * span
    inside = int(np.count_nonzero(np.abs(values - end) <= 0.01 * span))
    at = np.zeros(values.size, dtype=bool)
    for first, stop in runs_of(near):
        at[first:stop] |= stop - first >= FLAT_RUN
    return at, inside


def clips(there: int, inside: int, end: float, full_scale: float | None = None) -> bool:
    """Return whether an end with so many samples at it, and just inside it, is one where the channel clips."""
    if not there:
        return False
    return 2 * there >= inside or bool(full_scale and math.isclose(abs(end), full_scale, rel_tol=1e-3))
