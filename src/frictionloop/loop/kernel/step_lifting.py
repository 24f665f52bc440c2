"""Scalar steps lifted to tiles: one loop over lanes each, so that the compiler vectorises it.

The steps themselves live in their rooms and know nothing of lanes: `lift` loads the rows that a step needs, calls it,
and stores what it returns. A tile is compiled as a C function, ``tile(slab, k, at, shared)``: period k, its place in
the block, and the record of what lanes share. Each has a file on the disk of its own, and loops call it by address.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from threading import RLock
from typing import Any, NamedTuple

from numba import njit, types
from numba.core.errors import NumbaError

from frictionloop.loop.kernel.slab_access import load, store
from frictionloop.loop.kernel.tile_record import POINTER, at
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.code_version import code_digest
from frictionloop.quantities.compile_cache import compile_c
from frictionloop.quantities.outside_errors import complaint
from frictionloop.quantities.scalar_math import step

TILE = types.void(types.CPointer(types.float64), types.int64, types.int64, POINTER)
_compiled: dict[tuple[Any, ...], Any] = {}
_compiling = RLock()


class Lifting(NamedTuple):
    """How the parts of one tile are compiled."""

    width: int
    """Lanes of a tile."""
    compiled: Any
    """Decorator that compiles a function."""
    count: Any
    """n -> number of lanes to run: the constant 1 for single runs, so that their loops vanish."""


def lifting(name: str, width: int, inlined: bool = False) -> Lifting:
    """Return how to compile the functions of a tile for this width.

    ``inlined`` functions leave no calls in a control period.
    """
    suffix = f"_{name}_{width}".replace("-", "_")

    def compiled(function: Any) -> Any:
        # Functions from the disk that have one name would be one function to the linker.
        function.__qualname__ += suffix
        return njit(
            error_model="numpy", nogil=True, forceinline=inlined, no_cpython_wrapper=True, no_cfunc_wrapper=True
        )(function)

    def one(n):  # type: ignore[no-untyped-def]
        return 1

    def given(n):  # type: ignore[no-untyped-def]
        return n

    return Lifting(width, compiled, compiled(one if width == 1 else given))


def lift(lifting: Lifting, of_lane: Any, given: Sequence[Any], results: Any) -> Any:
    """Return ``part(s, n, *common)``: for every lane ``results = of_lane(*common, *given)``.

    Parameters
    ----------
    lifting
        Of the tile.
    of_lane
        Compiled by `quantities.scalar_math.step`.
    given, results
        Row numbers of the arguments and of what is returned, in their shapes: a number, a tuple or a named tuple.
        ``common`` is what the caller gives to all lanes: a time, or a place in the period.
    """
    width, compiled, count = lifting
    given = tuple(given)

    @compiled
    def part(s, n, *common):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            store(s, i, width, results, of_lane(*common, *load(s, i, width, given)))

    return part


@step
def same_step(value: Any) -> Any:
    """As it is."""
    return value


def lift_gather(lifting: Lifting, place: Any, between: Any, given: Sequence[Any], result: int) -> Any:
    """Return ``part(s, n, table)``: for every lane what lies between two entries of its own table.

    A gather does not vectorise, and so has a loop of its own.

    Parameters
    ----------
    lifting, given, result
        As of `lift`.
    place
        Step from what is given to the two entries, and how far what is looked up lies between them (0 to 1).
    between
        Step from this fraction and the two values to the result.
    """
    width, compiled, count = lifting
    given = tuple(given)

    @compiled
    def part(s, n, table):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            here, there, fraction = place(*load(s, i, width, given))
            values = load(table, i, width, (here, there))
            store(s, i, width, result, between(fraction, *values))

    return part


def compiled_tile(width: int, build: Callable[..., Any], *of: Any) -> int:
    """Return the address of the C function of the tile that ``build(lifting, *of)`` makes, compiled at most once.

    ``build`` returns a function ``body(s, n, k, at, o)`` of the slab, the number of lanes, the period, its place in the
    block and the record.
    """
    key = (build, width, *of)
    with _compiling:  # threads that start together must not compile it twice
        if key not in _compiled:
            name = "-".join([build.__name__.removeprefix("build_"), *(_name(each) for each in of)])
            _compiled[key] = _compile(build(lifting(name, width), *of), f"{name}-{width}")
        return int(_compiled[key].address)


def _name(of: Any) -> str:
    if of is None or isinstance(of, (str, int, bool)):
        return str(of)
    named = getattr(of, "kind", None) or of.name
    return f"{named}_{code_digest(of)[:8]}"


def _compile(body: Any, name: str) -> Any:
    def entry(s, k, place, shared):  # type: ignore[no-untyped-def]
        o = at(shared)
        body(s, o.lanes, k, place, o)

    try:
        return compile_c(TILE, entry, name)
    except NumbaError as error:
        raise FrictionloopError(f"{name}: {complaint(error)}") from None
