"""Named tuples of numbers, which may hold named tuples: as one flat row of numbers, and back."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, get_type_hints


@cache
def parts(shape: type) -> tuple[tuple[str, type | None], ...]:
    """Return the fields of a named tuple class, each with the named tuple class it holds, None for a number."""
    hints = get_type_hints(shape)
    return tuple((name, hints[name] if hasattr(hints.get(name), "_fields") else None) for name in shape._fields)  # type: ignore[attr-defined]


@cache
def size(shape: type) -> int:
    """Return how many numbers a named tuple class holds."""
    return sum(1 if inner is None else size(inner) for _, inner in parts(shape))


@cache
def names(shape: type) -> tuple[str, ...]:
    """Return the name of each number, dotted where a named tuple holds it."""
    found: list[str] = []
    for name, inner in parts(shape):
        found += [name] if inner is None else [f"{name}.{each}" for each in names(inner)]
    return tuple(found)


def flat(value: Any) -> list[Any]:
    """Return the numbers of a named tuple in order."""
    found: list[Any] = []
    for each in value:
        if isinstance(each, tuple):
            found += flat(each)
        else:
            found.append(each)
    return found


def shaped(shape: type, numbers: Sequence[Any]) -> Any:
    """Return the named tuple of this class that holds these numbers."""
    return _shaped(shape, iter(numbers))


def _shaped(shape: type, numbers: Iterator[Any]) -> Any:
    return shape(*(next(numbers) if inner is None else _shaped(inner, numbers) for _, inner in parts(shape)))
