"""Methods that choose levels, in PsychoPy's idiom: ``for level in handler: ...; handler.add_response(right)``.

A handler is told the level that was delivered. A posterior uses it; a staircase steps from the level it asked for.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Self

import numpy as np

from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.value_checks import numbers, whole

Result = bool | int | float


class Told(NamedTuple):
    """One trial that a handler was told of."""

    asked: float
    delivered: float
    result: float
    track: str


class Handler:
    """What all methods have in common: an iterator over levels that waits for the response to each."""

    def __init__(self) -> None:
        self.told: list[Told] = []
        """The trials so far."""

    level: float
    """The level asked for now."""
    track = ""
    """Name of the track that it is of, where several are interleaved."""
    results: tuple[int, ...] = (0, 1)
    """What a response may be; any number where there are none."""

    @property
    def finished(self) -> bool:
        """Whether no level is asked for any more."""
        raise NotImplementedError

    @property
    def state(self) -> str:
        """What the method knows now, in a few words for a table."""
        return ""

    def __iter__(self) -> Self:
        """Return the handler."""
        return self

    def __next__(self) -> float:
        """Return the level asked for; the same until a response is added."""
        if self.finished:
            raise StopIteration
        return self.level

    def add_response(self, result: Result, delivered: float | None = None) -> None:
        """Tell the response to the level asked for.

        Parameters
        ----------
        result : bool or number
            Whether the answer was right, 0 or 1; of constant stimuli and a walk any number that was given.
        delivered : float, optional
            Level that was delivered; the one asked for if not given.

        Raises
        ------
        FrictionloopError
            For a result that the method does not know, a level that is not finite, or after the last level.
        """
        if self.finished:
            raise FrictionloopError("add_response: the method has finished")
        given = self.level if delivered is None else delivered
        if not (math.isfinite(result) and math.isfinite(given)):
            raise must_be("result, delivered", (result, given), "finite")
        if self.results and result not in self.results:
            raise must_be("result", result, ", ".join(map(str, self.results)))
        self.told.append(Told(self.level, float(given), float(result), self.track))
        self._next(self.told[-1])

    def skip(self) -> None:
        """Go on without a response, where a trial is kept but does not count: most methods ask for the same again."""
        return

    addResponse = add_response
    """The name that PsychoPy's scripts use."""

    def _next(self, told: Told) -> None:
        raise NotImplementedError


class ConstantStimuli(Handler):
    """Each of some levels, equally often, in an order that is drawn in rounds of all levels.

    Parameters
    ----------
    levels : sequence of float
        Levels, in the unit of the protocol.
    repeats : int
        How often each is asked for.
    seed
        Seed of the order, as of ``numpy.random.default_rng``.
    """

    _skipped = 0
    results = ()

    def __init__(self, levels: Sequence[float], repeats: int = 10, seed: Any = 0) -> None:
        super().__init__()
        values, rng = numbers("levels", levels, ""), np.random.default_rng(seed)
        self._order = np.concatenate([rng.permutation(values) for _ in range(whole("repeats", repeats, 1))])

    @property
    def level(self) -> float:  # type: ignore[override]
        """The level asked for now."""
        return float(self._order[min(len(self.told) + self._skipped, self._order.size - 1)])

    @property
    def finished(self) -> bool:
        """Whether every level was asked for often enough."""
        return len(self.told) + self._skipped >= self._order.size

    def skip(self) -> None:
        """Go on to the next level."""
        self._skipped += 1

    def _next(self, told: Told) -> None:
        return


class Walk(ConstantStimuli):
    """A level that wanders between two ends by steps that are drawn: what a participant follows on a scale.

    Parameters
    ----------
    low, high : float
        Ends, at which it turns back.
    step : float
        Standard deviation of one step.
    trials : int
        Steps.
    seed
        Seed of the walk.
    """

    def __init__(self, low: float, high: float, step: float, trials: int = 60, seed: Any = 0) -> None:
        Handler.__init__(self)
        steps = np.random.default_rng(seed).normal(0.0, step, whole("trials", trials, 1))
        place = (np.cumsum(steps) + 0.5 * (high - low)) / (high - low)
        folded = np.abs(np.mod(place + 1.0, 2.0) - 1.0)
        self._order = low + (high - low) * folded


class Interleaved(Handler):
    """Several methods at once: which one asks next is drawn.

    Parameters
    ----------
    tracks : mapping
        Handlers by name.
    seed
        Seed of the order.
    """

    def __init__(self, tracks: Mapping[str, Handler], seed: Any = 0) -> None:
        super().__init__()
        if not tracks:
            raise must_be("tracks", tracks, "methods by name")
        self.tracks, self._rng = dict(tracks), np.random.default_rng(seed)
        self._draw()

    @property
    def level(self) -> float:  # type: ignore[override]
        """The level that the track drawn asks for."""
        return self.tracks[self.track].level

    @property
    def finished(self) -> bool:
        """Whether all tracks are done."""
        return all(each.finished for each in self.tracks.values())

    @property
    def state(self) -> str:
        """What the track drawn knows."""
        return self.tracks[self.track].state

    def skip(self) -> None:
        """Let the track go on, and draw anew."""
        self.tracks[self.track].skip()
        self._draw()

    def _next(self, told: Told) -> None:
        self.tracks[self.track].add_response(told.result, told.delivered)
        self._draw()

    def _draw(self) -> None:
        left = [name for name, each in self.tracks.items() if not each.finished]
        if left:
            self.track = left[int(self._rng.integers(len(left)))]
            self.results = self.tracks[self.track].results


class Adjustment(Handler):
    """The participant turns the level until two stimuli feel alike; again from a start that is drawn.

    A response of 1 asks for more, -1 for less, 0 says that they are alike.

    Parameters
    ----------
    low, high : float
        Ends of the levels; starts are drawn between.
    step : float
        Change by one response.
    settings : int
        Times that the participant sets the level.
    most : int
        Responses in one setting at most; the last level then is the setting.
    seed
        Seed of the starts.
    """

    results = (-1, 0, 1)

    def __init__(self, low: float, high: float, step: float, settings: int = 5, most: int = 30, seed: Any = 0) -> None:
        super().__init__()
        self.low, self.high, self.step, self._most = low, high, step, whole("most", most, 1)
        self._starts = np.random.default_rng(seed).uniform(low, high, whole("settings", settings, 1)).tolist()
        self.set: list[float] = []
        """The levels that were set so far."""
        self.level, self._made = self._starts[0], 0

    @property
    def finished(self) -> bool:
        """Whether the level was set often enough."""
        return len(self.set) >= len(self._starts)

    @property
    def state(self) -> str:
        """Settings so far."""
        return f"settings={len(self.set)}"

    def _next(self, told: Told) -> None:
        self._made += 1
        if told.result and self._made < self._most:
            self.level = min(max(self.level + math.copysign(self.step, told.result), self.low), self.high)
            return
        self.set.append(told.delivered)
        self._made = 0
        if not self.finished:
            self.level = self._starts[len(self.set)]
