"""What computes or measures behind a live page: two loops on one finger, simulated side by side."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np

from frictionloop.loop.kernel.structure import structure
from frictionloop.loop.live_loop import Guided
from frictionloop.parameters import System
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.source import EffectSource

CHANNELS = {
    "x_mm": ("mm", "place of the finger"),
    "load_n": ("N", "normal force"),
    "asked_n": ("N", "force asked for"),
    "open_n": ("N", "friction force, open loop"),
    "closed_n": ("N", "friction force, closed loop"),
    "measured_n": ("N", "measured force, closed loop"),
    "open_um": ("um", "vibration amplitude, open loop"),
    "closed_um": ("um", "vibration amplitude, closed loop"),
    "limit_n": ("N", "friction limit without vibration"),
    "floor_n": ("N", "friction limit at the largest amplitude"),
    "saturated": ("1", "the command of the closed loop is clamped"),
}
"""What an engine tells of every tick: unit and meaning; NaN where it does not know."""


class Engine(Protocol):
    """What stands behind a session: it moves on by blocks of ticks under a finger's path."""

    source: str
    """``simulated``, ``emulated`` or ``device``."""

    @property
    def system(self) -> System:
        """What runs."""

    @property
    def rate_hz(self) -> float:
        """Ticks per second."""

    def advance(self, path: np.ndarray) -> np.ndarray:
        """Go on by one tick per row of place (m), speed (m/s) and load (N); return `CHANNELS`, shape (11, ticks)."""

    def change(self, system: System) -> bool:
        """Put a System in force and return whether the loop went on without a restart."""


class TwinEngine:
    """Open and closed loop on the same finger, noise and touch.

    Parameters
    ----------
    system : System
        The closed loop; the open one has the lookup table alone, and all else of it.
    seed : int
        Seed of the noise of both.

    Raises
    ------
    FrictionloopError
        For a System whose finger does not move, or a bad seed.
    """

    source = "simulated"

    def __init__(self, system: System, seed: int = 0) -> None:
        self.system = system
        self._closed, self._open = Guided(system, seed), Guided(opened(system), seed)
        self._closed.change(system)  # what a change calls is loaded now: a session that runs would stand still for it
        self._compiled = {_loop_of(system)}

    @property
    def rate_hz(self) -> float:
        """Ticks per second."""
        return self.system.controller.rate_hz

    def advance(self, path: np.ndarray) -> np.ndarray:
        """Go on by one tick per row of the path, and return `CHANNELS` over the ticks."""
        closed = dict(zip(self._closed.names, self._closed.advance(path), strict=True))
        beside = dict(zip(self._open.names, self._open.advance(path), strict=True))
        return np.stack(
            [
                1e3 * closed["position"],
                closed["load"],
                closed["f_r"],
                beside["f_a"],
                closed["f_a"],
                closed["f_m"],
                beside["a"],
                closed["a"],
                closed["limit"],
                closed["floor"],
                closed["saturated"],
            ]
        )

    def ready(self, system: System) -> bool:
        """Tell whether a System runs on what has been compiled: `change` then takes no time."""
        return _loop_of(system) in self._compiled

    def prepare(self, system: System) -> None:
        """Compile what a System runs on, which takes seconds the first time; nothing else changes."""
        Guided(system)
        Guided(opened(system))
        self._compiled.add(_loop_of(system))

    def change(self, system: System) -> bool:
        """Put a System in force in both loops; they begin anew together where one has to."""
        went_on = self._closed.change(system)
        went_on = self._open.change(opened(system)) and went_on
        self.system = system
        return went_on


def _loop_of(system: System) -> tuple[object, ...]:
    """Return what decides on the code that a System runs on and on the tables that it reads.

    Of an effect that is its kind: the first one of a kind may compile what makes its tables.
    """
    source = system.setpoint
    kinds = frozenset(_kinds(source.effect)) if isinstance(source, EffectSource) else None
    return kinds, *structure(system)[1:]


def _kinds(effect: Effect) -> Iterator[str]:
    yield effect.kind
    for part in effect.parts:
        yield from _kinds(part)


def opened(system: System) -> System:
    """Return the System with its loop open: the lookup table alone commands."""
    return system.evolve({"controller.kind": "lookup"})
