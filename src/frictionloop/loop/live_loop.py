"""The closed loop in short blocks, under a finger that somebody moves, with numbers that change while it runs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit

from frictionloop.control.laws import law_of
from frictionloop.loop.kernel.law_tile import limits_step
from frictionloop.loop.kernel.loop import Tile
from frictionloop.loop.kernel.lowering import lower
from frictionloop.loop.kernel.slab import LANES, ROW, law_rows
from frictionloop.loop.kernel.tile_compatibility import moves, structure
from frictionloop.loop.kernel.traces import traces_of
from frictionloop.loop.simulate import check_seed, no_number
from frictionloop.parameters import System, check_system
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.compile_cache import keep_compiled
from frictionloop.quantities.counter_noise import BLOCK
from frictionloop.quantities.flat_tuples import flat

MOST = 4096
"""Most control periods of one call; of several systems together an eighth of it, for their traces are large."""
_STATE = "measurement", "friction", "effect_seen", "effect_true", "overdrive"


@njit(error_model="numpy")
def _limits(low: float, high: float, log2_nominal: float, um2_per_halving: float) -> tuple[float, float]:
    return limits_step(low, high, log2_nominal, um2_per_halving)


# Called from Python, while a session waits: compiled code is on the disk after the first time.
keep_compiled(_limits, "limits")


class Guided:
    """The loop of a System, block by block, under a finger that the caller moves.

    It is `simulate` with the finger's path from outside. Two of them with the same seed see the same noise. Several
    Systems of one structure run together, as lanes of a tile, under one path and one noise.

    Parameters
    ----------
    system : System or sequence of System
        What runs; its finger moves (``motion.kind`` "strokes"), of which only its person and what is felt are used.
    seed : int
        Seed of all noise, 0 to 2**64 - 1.

    Raises
    ------
    FrictionloopError
        For what is not a System, one whose finger does not move, Systems of different structure, or a bad seed.
    """

    def __init__(self, system: System | Sequence[System], seed: int = 0) -> None:
        self.systems, self._seed, self.period = _checked(system), check_seed(seed), 0
        self._begin()

    @property
    def system(self) -> System:
        """What runs, or the first of several."""
        return self.systems[0]

    def _begin(self) -> None:
        self.names = traces_of(self.system)
        """Names of the rows that `advance` returns, as the variables of a run."""
        width = 1 if len(self.systems) == 1 else LANES
        self._traces = np.zeros((len(self.names), MOST if width == 1 else MOST // 8, width))
        self._tile = self._lowered(self.systems)
        self._fresh = self._tile.slab.data.copy()

    def _lowered(self, systems: Sequence[System]) -> Tile:
        seeds = [self._seed] * len(systems)
        return lower(systems, seeds, traces=self._traces.reshape(-1), guided=True)

    def advance(self, path: np.ndarray) -> np.ndarray:
        """Run one control period for each row of a path and return the traces, shape (names, periods).

        Of several systems their shape is (names, periods, systems).

        Parameters
        ----------
        path : array, shape (periods, 3)
            Place (m), speed (m/s) and normal force (N) at the end of each period; at most `MOST` periods.

        Raises
        ------
        FrictionloopError
            When a force is no number, or a signal of the System is over.
        """
        path = np.ascontiguousarray(path, float)
        start, stop = self.period, self.period + len(path)
        _, most, width = self._traces.shape
        if not len(path) <= most:
            raise FrictionloopError(f"path: {len(path)} periods; at most {most} at once")
        tile, chunk = self._tile, start // BLOCK * BLOCK
        # Rows of both arrays are counted from t = 0, as in a run.
        tile.shared.set(path=path.ctypes.data - 24 * start, trace=self._traces.ctypes.data - 8 * width * start)
        tile.advance(start, stop, tile.setpoint(chunk, stop), tile.disturbance(chunk, stop), chunk)
        self.period = stop
        told = self._traces[:, : len(path), : len(self.systems)].copy()
        if np.isnan(told[:4]).any():
            raise no_number(self.system, f"at {stop / self.system.controller.rate_hz:g} s")
        return told[..., 0] if len(self.systems) == 1 else told

    def change(self, system: System | Sequence[System]) -> bool:
        """Put another System in force and return whether the loop went on: numbers change, the state stays.

        What makes another loop, as another law or rate does, begins anew at rest.

        Raises
        ------
        FrictionloopError
            As the constructor; the old System is then still in force.
        """
        systems = _checked(system)
        tile, running = self._lowered(systems), self._tile
        self.systems, old = systems, self.systems
        kinds = {each.controller.kind for each in (*systems, *old)}
        if len(systems) != len(old) or len(kinds) > 1 or not _alike(tile, running):
            self.period = 0
            self._begin()
            return False
        fresh = tile.slab.data.copy()
        kept = (fresh == self._fresh).reshape(-1, tile.slab.width)
        kept[state_rows(systems[0])] = True
        tile.slab.data[kept.ravel()] = running.slab.data[kept.ravel()]
        tile.shared.kept["history"][:] = running.shared.kept["history"]
        if len(systems) == 1:
            gains = law_rows(law_of(systems[0].controller))[1]
            given = [float(tile.slab.view(row)[0, 0]) for row in (*gains[-2:], *ROW["model"][:2])]
            tile.slab.view("at_limits")[:, 0] = _limits(*given)
        self._tile, self._fresh = tile, fresh
        return True


def _checked(system: System | Sequence[System]) -> tuple[System, ...]:
    """Return the systems, which a finger can be moved on and which run together."""
    systems = tuple(system) if isinstance(system, (list, tuple)) else (system,)
    for each in systems:
        check_system(each)
        if not moves(each):
            raise FrictionloopError('motion.kind = "sliding": must be "strokes"')
    if not 0 < len(systems) <= LANES:
        raise FrictionloopError(f"systems: {len(systems)}; must be 1 to {LANES}")
    if len(systems) > 1 and any(structure(each) != structure(systems[0]) for each in systems[1:]):
        raise FrictionloopError("systems: must differ in numbers alone")
    return systems


def _alike(a: Tile, b: Tile) -> bool:
    """Tell whether two tiles run the same program, so that one can go on with the other's state."""
    counts = ("segments", "before", "nodes", "lanes", "ring_mask", "table_size", "open_until", "dt")
    programs = (np.array_equal(a.shared.kept[name], b.shared.kept[name]) for name in ("blocks", "ticks"))
    return all(programs) and all(getattr(a.shared, name) == getattr(b.shared, name) for name in counts)


def state_rows(system: System) -> list[int]:
    """Return the rows of a slab that a loop keeps when its numbers change."""
    rows = [row for name in _STATE for row in flat((ROW[name],))]
    return [*rows, *flat((law_rows(law_of(system.controller))[0],))]
