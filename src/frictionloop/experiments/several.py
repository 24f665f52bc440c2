"""Methods made of others, or of the participant's own settings: interleaved tracks, and adjustment."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from frictionloop.experiments.methods import Handler, Told
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.checks import whole


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
            raise FrictionloopError("tracks: must be methods by name")
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
