"""The tile of the firmware's controller: the compiled C core in the place of law, lookup and overdrive.

Its state and its words live in a block of memory per lane that only the C code reads. The address of the C function
is a number that the options carry, so that a kernel from the disk cache calls the library of its own process.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from frictionloop.loop.kernel.access import doubles, load, peek, poke, store, words
from frictionloop.loop.kernel.shared import CORE_GIVEN, CORE_TOLD
from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.tiles import Lifting


@intrinsic
def call_c(_context: Any, address: Any, context: Any, at: Any, given: Any) -> Any:
    """Call the C function ``void (*)(int32_t *context, double *given)`` at an address, its context from word ``at``."""

    def generate(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
        word, number = ir.IntType(32).as_pointer(), ir.DoubleType().as_pointer()
        function = ir.FunctionType(ir.VoidType(), [word, number]).as_pointer()
        where = builder.gep(args[1], [args[2]])
        builder.call(builder.inttoptr(args[0], function), [where, args[3]])
        return _ctx.get_dummy_value()

    return types.void(types.int64, context, types.intp, given), generate


def build_fixed(lifting: Lifting) -> Any:
    """Return the tile that lets the C core decide, but for lanes whose tick is lost."""
    width, compiled, count = lifting
    given_rows, told_rows = (*ROW["measurement"], ROW["setpoint"]), (ROW["u"], ROW["saturated"], ROW["command"])
    drawn, below = ROW["timing_draws"][1], ROW["timing"][2]
    given_places, told_places = tuple(range(CORE_GIVEN - 1)), tuple(range(CORE_GIVEN, CORE_GIVEN + CORE_TOLD))

    @compiled
    def fixed(s, n, k, at, o):  # type: ignore[no-untyped-def]
        context, size, given = words(o.core_context), o.core_words, doubles(o.core_given)
        poke(given, CORE_GIVEN - 1, 1.0 if k >= o.open_until else 0.0)
        for i in range(count(n)):
            lost = (o.irregular != 0) and peek(s, drawn * width + i) < peek(s, below * width + i)
            if not lost:
                store(given, 0, 1, given_places, load(s, i, width, given_rows))
                call_c(o.core, context, i * size, given)
                store(s, i, width, told_rows, load(given, 0, 1, told_places))

    return fixed
