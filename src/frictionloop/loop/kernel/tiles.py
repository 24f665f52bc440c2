"""Scalar steps lifted to tiles: one loop over lanes each, so that the compiler vectorises it.

A tile loads the rows a step needs, calls it, and stores what it returns. The steps themselves live in their rooms and
know nothing of lanes. Here are the tiles that move numbers; those that compute are in control_tile, plant_tile and
score_tile.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import njit

from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.slab_access import peek, poke

TRACES = ("f_r", "f_a", "f_m", "u", "a", "d", "saturated")
BENCH_TRACES = (*TRACES, "position", "speed", "load", "limit", "floor", "sliding", "scored")
"""Traces of the two kernels, in the order of their rows."""
_BENCH_ROWS = (*rows("motion")[:3], ROW["nominal"], ROW["floor"], ROW["measurement"] + 4, ROW["scored"])


def traces_of(kernel: str) -> tuple[str, ...]:
    """Return the names of the traces that a kernel records."""
    return TRACES if kernel == "quadrature" else BENCH_TRACES


class Lifting(NamedTuple):
    """How the tiles of one kernel are compiled."""

    width: int
    """Lanes of a tile."""
    compiled: Any
    """Decorator that compiles a function."""
    count: Any
    """n -> number of lanes to run: the constant 1 for single runs, so that their loops vanish."""


def lifting(kernel: str, width: int, inlined: bool = False) -> Lifting:
    """Return how to compile the functions of a kernel for tiles of this width.

    ``inlined`` functions leave no calls in a control period, each of which would copy all options to the stack.

    Kernel and width become part of every function's name: kernels are loaded from disk, where functions of different
    processes have the same names, and the linker takes the first function of a name for all of them.
    """

    def compiled(function: Any) -> Any:
        function.__qualname__ += f"_{kernel}_{width}"
        return njit(error_model="numpy", nogil=True, forceinline=inlined)(function)

    def one(n):  # type: ignore[no-untyped-def]
        return 1

    def given(n):  # type: ignore[no-untyped-def]
        return n

    return Lifting(width, compiled, compiled(one if width == 1 else given))


def build_inputs(lifting: Lifting) -> Any:
    """Return the tiles that bring a signal into its row, and that start the sensor settled on the first force."""
    width, compiled, count = lifting
    force, friction_row, disturbance = ROW["measurement"], ROW["friction"], ROW["disturbance"]

    @compiled
    def spread(s, n, row, values, k, shared):  # type: ignore[no-untyped-def]
        if shared:
            value = peek(values, k)
            for i in range(count(n)):
                poke(s, row * width + i, value)
        else:
            for i in range(count(n)):
                poke(s, row * width + i, peek(values, k * width + i))

    @compiled
    def settle(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            poke(s, force * width + i, peek(s, friction_row * width + i) + peek(s, disturbance * width + i))

    return spread, settle


def build_delay(lifting: Lifting) -> Any:
    """Pick the commands in force during this period when they are applied later than the sample."""
    width, compiled, count = lifting
    command, applied, delay = ROW["command"], ROW["applied"], ROW["delay_periods"]

    @compiled
    def apply_late(s, n, k, history, mask):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            poke(history, (k & mask) * width + i, peek(s, command * width + i))
            since = k - int(peek(s, delay * width + i))
            poke(s, (applied + 1) * width + i, peek(history, (since & mask) * width + i))
            poke(s, applied * width + i, peek(history, ((since - 1) & mask) * width + i))

    return apply_late


def build_record(lifting: Lifting, traces: tuple[str, ...] = TRACES) -> Any:
    """Return the tile that writes the traces of one period, ``[trace][period][lane]``."""
    width, compiled, count = lifting
    force, u, sat, r, d = ROW["measurement"], ROW["u"], ROW["saturated"], ROW["setpoint"], ROW["disturbance"]
    amplitude, friction_row = ROW["amplitude"], ROW["friction"]
    more = traces[len(TRACES) :]

    @compiled
    def record(s, n, k, out, size):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            at = k * width + i
            disturbance = peek(s, d * width + i)
            poke(out, at, peek(s, r * width + i))
            poke(out, size + at, peek(s, friction_row * width + i) + disturbance)
            poke(out, 2 * size + at, peek(s, force * width + i))
            poke(out, 3 * size + at, peek(s, u * width + i))
            poke(out, 4 * size + at, peek(s, amplitude * width + i))
            poke(out, 5 * size + at, disturbance)
            poke(out, 6 * size + at, peek(s, sat * width + i))
            if more:
                for j in range(len(_BENCH_ROWS)):
                    poke(out, (7 + j) * size + at, peek(s, _BENCH_ROWS[j] * width + i))

    return record
