"""Who is told of compilations; apart from what compiles, which takes long to load."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

COMPILING = "; compiling for it, once after an installation"
"""Follows what is under way while something is compiled."""
on_compiling: list[Callable[[bool], None]] = []
"""Called with True before something is compiled that the disk does not have, and with False when it is done."""


def tell_compiling(begins: bool) -> None:
    """Tell all who listen."""
    for listener in on_compiling:
        listener(begins)


@contextmanager
def compiling() -> Iterator[None]:
    """Tell all who listen that something is compiled, and that it is done or has failed."""
    tell_compiling(True)
    try:
        yield
    finally:
        tell_compiling(False)
