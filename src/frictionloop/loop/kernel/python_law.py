"""A control law in plain Python as a tile: the kernel calls back for every lane."""

from __future__ import annotations

import ctypes
from typing import Any

from frictionloop.control.law import Law
from frictionloop.loop.kernel.columns import Slab
from frictionloop.loop.kernel.law_tile import lift_lookup, lift_overdrive
from frictionloop.loop.kernel.slab import law_rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.quantities import trees
from frictionloop.quantities.blame import theirs
from frictionloop.sensing.measurement import Measurement

_CALL = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64, ctypes.c_void_p)


class PythonLaw:
    """A law's tick for all lanes of a slab; ``address`` is that of a tile."""

    def __init__(self, law: Law, slab: Slab, dt: float) -> None:
        self.law, self.slab, self.dt = law, slab, dt
        self.state_rows, self.gain_rows, _ = law_rows(law)
        self.error: BaseException | None = None
        self._call = _CALL(self._tick)
        self.address = int(ctypes.cast(self._call, ctypes.c_void_p).value or 0)

    def _tick(self, _slab: int, _k: int, _at: int, _record: int) -> None:
        if self.error is not None:  # the caller learns of it when its chunk is over
            return
        try:
            for lane in range(self.slab.width):
                self._lane(lane)
        except Exception as error:
            self.error = theirs(f'law "{self.law.kind}"', self.law.step, error)
        except BaseException as error:
            self.error = error

    def _lane(self, lane: int) -> None:
        states, gains = self.slab.view(self.state_rows), self.slab.view(self.gain_rows)
        measured = Measurement(*self.slab.view("measurement")[:, lane].tolist())
        before = trees.shaped(self.law.state, states[:, lane].tolist())
        given = trees.shaped(self.law.gains, gains[:, lane].tolist())
        setpoint_n = float(self.slab.view("setpoint")[0, lane])
        after, (u, saturated) = self.law.step(before, measured, setpoint_n, given, self.dt)
        states[:, lane] = trees.flat(after)
        self.slab.view("u")[0, lane], self.slab.view("saturated")[0, lane] = u, saturated


def build_lookup(lifting: Lifting, table: bool) -> Any:
    """Return the tile that turns force commands into amplitudes, behind a law that only says the force."""
    look_up, overdrive = lift_lookup(lifting, table), lift_overdrive(lifting)

    @lifting.compiled
    def lookup(s, n, k, at, o):  # type: ignore[no-untyped-def]
        look_up(s, n, o)
        overdrive(s, n)

    return lookup
