"""Several people under one stroke: each of them with the loop open and closed, all in two tiles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from frictionloop.device.live_engine import CHANNELS, opened
from frictionloop.device.live_path import FASTEST_MM_S
from frictionloop.loop.live_loop import Guided
from frictionloop.parameters import System
from frictionloop.physics.reach import Reach

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

    Raises
    ------
    FrictionloopError
        For people that do not fit the System, or Systems that do not run together.
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
