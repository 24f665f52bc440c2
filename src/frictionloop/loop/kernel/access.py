"""How compiled code reads and writes the rows of a slab: by address, a value or some rows of a lane at a time."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload


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


def _pointer(kind: Any) -> Any:
    @intrinsic
    def at(_context: Any, address: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            return builder.inttoptr(args[0], context.get_value_type(signature.return_type))

        return types.CPointer(kind)(types.int64), generate

    return at


doubles, wholes = _pointer(types.float64), _pointer(types.int64)
words, keys = _pointer(types.int32), _pointer(types.uint64)
"""The numbers at an address (compiled code only)."""


@intrinsic
def call_tile(_context: Any, address: Any, slab: Any, k: Any, at: Any, shared: Any) -> Any:
    """Call the tile at an address (loop/kernel/tiles)."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        given = [context.get_value_type(kind) for kind in signature.args[1:]]
        function = ir.FunctionType(ir.VoidType(), given).as_pointer()
        builder.call(builder.inttoptr(args[0], function), args[1:])
        return context.get_dummy_value()

    return types.void(types.int64, slab, types.int64, types.int64, shared), generate


def load(slab: Any, lane: int, width: int, row_numbers: Any) -> Any:
    """Return the values of some rows for one lane, in the shape of the row numbers (compiled code only).

    Row numbers are a tuple or a named tuple, which may hold others.
    """
    raise NotImplementedError


def store(slab: Any, lane: int, width: int, row_numbers: Any, values: Any) -> None:
    """Set some rows for one lane from values of the same shape (compiled code only)."""
    raise NotImplementedError


@overload(load)
def _load(slab, lane, width, row_numbers):  # type: ignore[no-untyped-def]
    if isinstance(row_numbers, types.Integer):
        return lambda slab, lane, width, row_numbers: peek(slab, row_numbers * width + lane)
    if isinstance(row_numbers, types.BaseNamedTuple):
        shape, whole = row_numbers.instance_class, len(row_numbers)
        return lambda slab, lane, width, row_numbers: shape(*load(slab, lane, width, row_numbers[:whole]))
    if len(row_numbers) == 0:
        return lambda slab, lane, width, row_numbers: ()
    if len(row_numbers) == 1:
        return lambda slab, lane, width, row_numbers: (load(slab, lane, width, row_numbers[0]),)
    half = len(row_numbers) // 2  # one by one, compiling a law of many gains would run out of Python's stack

    def load_halves(slab, lane, width, row_numbers):  # type: ignore[no-untyped-def]
        return (*load(slab, lane, width, row_numbers[:half]), *load(slab, lane, width, row_numbers[half:]))

    return load_halves


@overload(store)
def _store(slab, lane, width, row_numbers, values):  # type: ignore[no-untyped-def]
    if isinstance(row_numbers, types.Integer):
        return lambda slab, lane, width, row_numbers, values: poke(slab, row_numbers * width + lane, float(values))
    if len(row_numbers) == 0:
        return lambda slab, lane, width, row_numbers, values: None
    if len(row_numbers) == 1:
        return lambda slab, lane, width, row_numbers, values: store(slab, lane, width, row_numbers[0], values[0])
    half = len(row_numbers) // 2

    def store_halves(slab, lane, width, row_numbers, values):  # type: ignore[no-untyped-def]
        store(slab, lane, width, row_numbers[:half], values[:half])
        store(slab, lane, width, row_numbers[half:], values[half:])

    return store_halves


BY_TYPE = (_load, _store)
"""Implementations that the compiler finds by type, so that no function names them."""
