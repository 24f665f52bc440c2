"""How compiled code reads and writes the rows of a slab: by address, some rows of a lane at a time.

It knows no negative indices, whose test would keep a loop from vectorising. An array of numbers is rows of one lane.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


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
def call(_context: Any, address: Any, given: Any) -> Any:
    """Call the C function at an address with a tuple of what it is given."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        kinds = [context.get_value_type(kind) for kind in signature.args[1].types]
        function = ir.FunctionType(ir.VoidType(), kinds).as_pointer()
        parts = [builder.extract_value(args[1], i) for i in range(len(kinds))]
        builder.call(builder.inttoptr(args[0], function), parts)
        return context.get_dummy_value()

    return types.void(types.int64, given), generate


@intrinsic
def load(_context: Any, slab: Any, lane: Any, width: Any, row_numbers: Any) -> Any:
    """Return the values of some rows for one lane, in the shape of the row numbers.

    Row numbers are a number, a tuple or a named tuple, which may hold others.
    """

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        def values(kind: Any, numbers: Any) -> Any:
            if isinstance(kind, types.Integer):
                return builder.load(_cell(builder, args, numbers))
            parts = [values(each, builder.extract_value(numbers, i)) for i, each in enumerate(kind.types)]
            return context.make_tuple(builder, _shape(kind, signature.args[0].dtype), parts)

        return values(signature.args[3], args[3])

    return _shape(row_numbers, slab.dtype)(slab, types.intp, types.intp, row_numbers), generate


@intrinsic
def store(_context: Any, slab: Any, lane: Any, width: Any, row_numbers: Any, given: Any) -> Any:
    """Set some rows for one lane from values of the same shape."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        def put(kind: Any, numbers: Any, of: Any, value: Any) -> None:
            if isinstance(kind, types.Integer):
                number = context.cast(builder, value, of, types.float64)
                builder.store(number, _cell(builder, args, numbers))
                return
            for i, (each, part) in enumerate(zip(kind.types, of.types, strict=True)):
                put(each, builder.extract_value(numbers, i), part, builder.extract_value(value, i))

        put(signature.args[3], args[3], signature.args[4], args[4])
        return context.get_dummy_value()

    return types.void(slab, types.intp, types.intp, row_numbers, given), generate


def _cell(builder: Any, args: Any, row: Any) -> Any:
    """Return the address of a row's value in a lane."""
    data, lane, width = args[:3]
    index = builder.add(builder.mul(row, width, flags=["nsw"]), lane, flags=["nsw"])
    return builder.gep(data, [index], inbounds=True)


def _shape(kind: Any, number: Any) -> Any:
    """Return the type of the values of row numbers."""
    if isinstance(kind, types.Integer):
        return number
    inner = [_shape(each, number) for each in kind.types]
    return types.BaseTuple.from_types(inner, getattr(kind, "instance_class", None))
