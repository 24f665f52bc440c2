"""What computes behind a live page: open and closed loop on one finger, or on several people under one stroke."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from frictionloop.live.pointer_motion import FASTEST_MM_S
from frictionloop.loop.kernel.tile_compatibility import structure
from frictionloop.loop.live_loop import Guided
from frictionloop.parameters import System
from frictionloop.physics.reach import Reach
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.effect_setpoint import EffectSource

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
    """Open and closed loop on the same finger, noise and touch."""

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


CROWD = ("asked_n", "open_n", "closed_n", "beyond")
"""What is told of every person: force asked for, forces of both loops, and whether the wish is out of reach."""
_PLACE, _LOAD = (list(CHANNELS).index(name) for name in ("x_mm", "load_n"))


class Crowd:
    """A System with one finger after another, all stroked at once; open and closed loop see the same noise.

    Parameters
    ----------
    system : System
        The bench and the law; what the people override is left out of it.
    people : sequence of mappings
        Overrides of each, such as ``fl.fingers(12, seed)``: at most 32.
    seed : int
        Seed of all noise.
    """

    def __init__(self, system: System, people: Sequence[Mapping[str, Any]], seed: int = 0) -> None:
        self.people, self._x_m = tuple(people), 0.0
        everybody = self._each(system)
        self._closed, self._open = Guided(everybody, seed), Guided([opened(each) for each in everybody], seed)

    def _each(self, system: System) -> list[System]:
        return [system.evolve(person) for person in self.people]

    @property
    def rate_hz(self) -> float:
        """Ticks per second."""
        return self._closed.systems[0].controller.rate_hz

    def change(self, system: System) -> None:
        """Put another System in force for everybody."""
        everybody = self._each(system)
        self._closed.change(everybody)
        self._open.change([opened(each) for each in everybody])

    def advance(self, rows: np.ndarray) -> np.ndarray:
        """Let everybody stroke along a stretch of a session.

        Parameters
        ----------
        rows : array, shape (channels, ticks)
            `CHANNELS` of the stretch, of which place and load count.

        Returns
        -------
        array, shape (4, ticks, people)
            `CROWD`, float32.
        """
        path = self._path(rows)
        closed = dict(zip(self._closed.names, self._closed.advance(path), strict=True))
        beside = dict(zip(self._open.names, self._open.advance(path), strict=True))
        wish = closed["f_r"] - closed["d"]
        beyond = Reach(closed["floor"], closed["limit"]).beyond(wish)
        told = closed["f_r"], beside["f_a"], closed["f_a"], beyond
        return np.stack(told).astype(np.float32).reshape(len(told), len(path), len(self.people))

    def _path(self, rows: np.ndarray) -> np.ndarray:
        """Return place (m), speed (m/s) and load (N); a finger that is in the air goes at once to where it lands."""
        path = np.empty((rows.shape[1], 3))
        # What a device does not know of its finger is a finger that is not there.
        path[:, 0] = np.where(np.isnan(rows[_PLACE]), self._x_m, 1e-3 * rows[_PLACE])
        path[:, 2] = np.nan_to_num(rows[_LOAD])
        speed = np.diff(path[:, 0], prepend=self._x_m) * self.rate_hz
        path[:, 1] = np.where(np.abs(speed) > 1.01e-3 * FASTEST_MM_S, 0.0, speed)
        self._x_m = float(path[-1, 0])
        return path
