"""How compiled code reads and writes the rows of a slab: by address, a value or some rows of a lane at a time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic, overload


@intrinsic
def pointer(_context: Any, array: Any) -> Any:
    """Return the address of an array's data: unlike the array it has no reference count to keep inside loops."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return context.make_array(signature.args[0])(context, builder, args[0]).data

    return types.CPointer(array.dtype)(array), generate


@intrinsic
def peek(_context: Any, data: Any, index: Any) -> Any:
    """Return data[index], without Python's negative indices, whose test would keep a loop from vectorising."""

    def generate(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.load(builder.gep(args[0], [args[1]], inbounds=True))

    return data.dtype(data, types.intp), generate


@intrinsic
def poke(_context: Any, data: Any, index: Any, value: Any) -> Any:
    """Set data[index] = value."""

    def generate(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        builder.store(args[2], builder.gep(args[0], [args[1]], inbounds=True))
        return context.get_dummy_value()

    return types.void(data, types.intp, data.dtype), generate


def load(slab: np.ndarray, lane: int, width: int, row_numbers: tuple[int, ...]) -> tuple[float, ...]:
    """Return the values of some rows for one lane as a tuple (compiled code only)."""
    raise NotImplementedError


def store(slab: np.ndarray, lane: int, width: int, row_numbers: tuple[int, ...], values: tuple[float, ...]) -> None:
    """Set some rows for one lane (compiled code only)."""
    raise NotImplementedError


@overload(load)
def _load(slab, lane, width, row_numbers):  # type: ignore[no-untyped-def]
    if len(row_numbers) == 0:
        return lambda slab, lane, width, row_numbers: ()
    if len(row_numbers) == 1:
        return lambda slab, lane, width, row_numbers: (peek(slab, row_numbers[0] * width + lane),)

    half = len(row_numbers) // 2  # one by one, compiling a law of many gains would run out of Python's stack

    def load_halves(slab, lane, width, row_numbers):  # type: ignore[no-untyped-def]
        return (*load(slab, lane, width, row_numbers[:half]), *load(slab, lane, width, row_numbers[half:]))

    return load_halves


@overload(store)
def _store(slab, lane, width, row_numbers, values):  # type: ignore[no-untyped-def]
    if len(row_numbers) == 0:
        return lambda slab, lane, width, row_numbers, values: None

    if len(row_numbers) == 1:
        return lambda slab, lane, width, row_numbers, values: poke(slab, row_numbers[0] * width + lane, values[0])
    half = len(row_numbers) // 2

    def store_halves(slab, lane, width, row_numbers, values):  # type: ignore[no-untyped-def]
        store(slab, lane, width, row_numbers[:half], values[:half])
        store(slab, lane, width, row_numbers[half:], values[half:])

    return store_halves
