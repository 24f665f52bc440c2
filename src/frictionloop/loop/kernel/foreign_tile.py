"""Tiles whose program comes from outside: effects, and laws in plain Python.

An effect runs at the place that the controller knows of, and at the true place beside it; the program is what
`rendering.effect_program` says. Lanes of a tile share it; each has its own state.
"""

from __future__ import annotations

import ctypes
from typing import Any

from frictionloop.control.law import Law
from frictionloop.loop.kernel.slab import ROW, law_rows
from frictionloop.loop.kernel.slab_access import doubles, load, store
from frictionloop.loop.kernel.slab_columns import Slab
from frictionloop.loop.kernel.step_lifting import Lifting
from frictionloop.quantities import flat_tuples
from frictionloop.quantities.outside_errors import theirs
from frictionloop.rendering.effect_program import build_play
from frictionloop.sensing.measurement import Measurement


def build_effect(lifting: Lifting, plain: bool) -> Any:
    """Return the tile that sets the set-point of a period, and what the effect asks for at the true place."""
    width, compiled, count = lifting
    play, clamp = build_play(compiled, width, plain), ROW["believed_clamp"]
    told, touch = ROW["measurement"], ROW["touch_coefficients"].touch_n
    seen, true = (ROW[name].direction * width for name in ("effect_seen", "effect_true"))
    stack = ROW["effect_stack"][0] * width
    predicted = ROW["effect_lead"], ROW["touch"].position, ROW["touch"].speed
    moving, setpoint, intended = ROW["motion"][:3], ROW["setpoint"], ROW["intended"]

    @compiled
    def effect(s, n, k, at, o):  # type: ignore[no-untyped-def]
        p = doubles(o.effect)
        for i in range(count(n)):
            lead, tracked, rate = load(s, i, width, predicted)
            _, position, speed, pressed, _ = load(s, i, width, told)
            along = tracked + lead * rate if lead >= 0.0 else position
            band, touches = load(s, i, width, clamp), load(s, i, width, touch)
            known = 1e3 * along, 1e3 * speed, pressed, touches
            asked, _ = play(s, seen + i, stack + i, p, *known, band, k * o.dt, k == 0, o.dt)
            store(s, i, width, setpoint, asked)
            if o.trace_size > 0:  # what is asked for at the true place is a trace alone
                x, v, load_n = load(s, i, width, moving)
                there = 1e3 * x, 1e3 * v, load_n, 1e-12
                wanted, _ = play(s, true + i, stack + i, p, *there, band, k * o.dt, k == 0, o.dt)
                store(s, i, width, intended, wanted)

    return effect


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
        before = flat_tuples.shaped(self.law.state, states[:, lane].tolist())
        given = flat_tuples.shaped(self.law.gains, gains[:, lane].tolist())
        setpoint_n = float(self.slab.view("setpoint")[0, lane])
        after, (u, saturated) = self.law.step(before, measured, setpoint_n, given, self.dt)
        states[:, lane] = flat_tuples.flat(after)
        self.slab.view("u")[0, lane], self.slab.view("saturated")[0, lane] = u, saturated
