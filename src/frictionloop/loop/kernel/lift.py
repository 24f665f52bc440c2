"""The adapter: a scalar step over all lanes, its arguments and results named by their rows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from frictionloop.loop.kernel.access import load, store
from frictionloop.loop.kernel.tiles import Lifting


def lift(lifting: Lifting, step: Any, given: Sequence[Any], results: Any, extra: int = 0) -> Any:
    """Return ``part(s, n, *extra)``: for every lane ``results = step(*extra, *given)``.

    Parameters
    ----------
    lifting
        Of the tile.
    step
        Compiled by `quantities.arithmetic.step`.
    given, results
        Row numbers of the arguments and of what is returned, in their shapes: a number, a tuple or a named tuple.
    extra
        How many arguments, 0 to 2, all lanes share and the caller gives: a time, or a place in the period.
    """
    width, compiled, count = lifting
    given = tuple(given)

    @compiled
    def plain(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            store(s, i, width, results, step(*load(s, i, width, given)))

    @compiled
    def with_one(s, n, x):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            store(s, i, width, results, step(x, *load(s, i, width, given)))

    @compiled
    def with_two(s, n, x, y):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            store(s, i, width, results, step(x, y, *load(s, i, width, given)))

    return (plain, with_one, with_two)[extra]
