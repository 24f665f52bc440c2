"""The order of everything in a session: a function of the protocol, the participant and the rows so far.

A session that was killed goes on with the same trials and the same posterior: its rows are told again.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

import numpy as np

from frictionloop.experiments.level_handlers import Handler
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.trial_structure import Condition

MOST_MARKED = 60
"""Trials of a condition that are kept without counting at most; then it is given up (assumed)."""
Phase = Literal["practice", "main", "catch"]


class Trial(NamedTuple):
    """One trial to present."""

    number: int
    """Counted from 1 over the session; the row it gets."""
    block: int
    """Counted from 1, in the order that they are run."""
    condition: Condition
    phase: Phase
    level: float
    """Level asked for."""
    comparison: int
    """Interval with the comparison, 1 or 2."""
    track: str
    state: str
    """What the method knew before."""
    repeat_of: int
    """The first trial that this one repeats, 0 for none."""
    seeds: tuple[int, ...]
    """Seed of each interval."""
    pause: bool
    """Whether there is a break before it."""


def latin_square(n: int) -> list[list[int]]:
    """Return the rows of a balanced Latin square: each follows each other one equally often (Williams 1949).

    n rows for an even n, 2 n for an odd one.
    """
    first = [0]
    for k in range(1, n):
        first.append((n - (k // 2)) % n if k % 2 == 0 else (k + 1) // 2)
    rows = [[(each + shift) % n for each in first] for shift in range(n)]
    return rows if n % 2 == 0 else rows + [row[::-1] for row in rows]


def participant_number(code: str) -> int:
    """Return the number in a code, by which conditions are counterbalanced: P07 is 7; of one without, a checksum."""
    digits = "".join(each for each in code if each.isdigit())
    return int(digits) if digits else zlib.crc32(code.encode())


class TrialOrder:
    """The trials of one session, one at a time."""

    def __init__(self, protocol: Protocol, participant: str) -> None:
        self.protocol, self.participant = protocol, participant
        self._person = zlib.crc32(participant.encode())
        self._order = self._ordered()
        self._number, self._first = 1, 0
        self.block = -1
        """Conditions that are done."""
        self.repeats = 0
        """How often the trial that is next was repeated already."""
        self.given_up: list[str] = []
        """Names of the conditions that ended because too many trials did not count."""
        self.handler: Handler
        """The method of the condition that is run."""
        self._begin()

    @property
    def conditions(self) -> list[Condition]:
        """The conditions in the order that they are run."""
        return [self.protocol.conditions[k] for k in self._order]

    def _rng(self, *more: int) -> np.random.Generator:
        return np.random.default_rng([self.protocol.seed, self._person, *more])

    def _ordered(self) -> list[int]:
        n, how = len(self.protocol.conditions), self.protocol.blocks.order
        if how == "random":
            return [int(k) for k in self._rng(0).permutation(n)]
        if how == "given" or n == 1:
            return list(range(n))
        square = latin_square(n)
        return square[(participant_number(self.participant) - 1) % len(square)]

    def _begin(self) -> None:
        """Begin the next condition."""
        self.block += 1
        self._practised = self._marked = self._since_break = self._counted = 0
        self._started_s: float | None = None
        self._late = False
        if self.block < len(self._order):
            p = self.protocol
            self.handler = p.method.handler([p.seed, self._person, 1, self.block], p.stop, p.guess)

    @property
    def finished(self) -> bool:
        """Whether all conditions are done."""
        return self.block >= len(self._order)

    def next(self) -> Trial | None:
        """Return the trial to present, the same until its row is told; None at the end."""
        if self.finished:
            return None
        p, rng = self.protocol, self._rng(2, self._number)
        comparison = int(rng.integers(1, 3)) if p.intervals == 2 else 1
        caught = rng.random() < p.blocks.catch_share
        seeds = tuple(int(each) for each in rng.integers(0, 2**62, p.intervals))
        highest = p.method.extremes()[1]
        phase: Phase = "main"
        level = self.handler.level
        if self._practised < p.blocks.practice:
            phase = "practice"
            level = highest if p.blocks.practice_level is None else p.blocks.practice_level
        elif caught and not self.repeats:
            phase = "catch"
            level = highest if p.blocks.catch_level is None else p.blocks.catch_level
        pause = phase != "practice" and 0 < p.blocks.break_every <= self._since_break
        return Trial(
            self._number, self.block + 1, self.conditions[self.block], phase, level, comparison,
            self.handler.track, self.handler.state, self._first if self.repeats else 0, seeds, pause,
        )  # fmt: skip

    def tell(self, row: Mapping[str, Any]) -> None:
        """Tell a trial's row, which decides what follows.

        ``counted`` says whether the method is told, ``again`` whether the trial is repeated, ``result`` and
        ``delivered`` what the method is told, ``offset_s`` the time.
        """
        phase, number = row["phase"], self._number
        self._number += 1
        if self._since_break >= self.protocol.blocks.break_every:
            self._since_break = 0
        self._since_break += phase != "practice"
        if self._started_s is None:
            self._started_s = float(row["onset_s"])
        limit = self.protocol.stop.time_s
        self._late = limit is not None and float(row["offset_s"]) - self._started_s >= limit
        if row["again"]:
            self._first = self._first if self.repeats else number
            self.repeats += 1
            return
        self.repeats = 0
        if phase == "practice":
            self._practised += 1
        elif phase == "main" and row["counted"]:
            self._counted += 1
            self.handler.add_response(float(row["result"]), float(row["delivered"]))
        elif phase == "main":
            self._marked += 1
            self.handler.skip()
        if self._over():
            if self._marked >= MOST_MARKED:
                self.given_up.append(self.conditions[self.block].name)
            self._begin()

    def _over(self) -> bool:
        enough = self.protocol.stop.trials is not None and self._counted >= self.protocol.stop.trials
        done = self.handler.finished or enough or self._late or self._marked >= MOST_MARKED
        return self._practised >= self.protocol.blocks.practice and done
