"""Who is told of compilations; apart from what compiles, which takes long to load."""

from __future__ import annotations

from collections.abc import Callable

on_compiling: list[Callable[[bool], None]] = []
"""Called with True before something is compiled that the disk does not have, and with False when it is done."""


def tell_compiling(begins: bool) -> None:
    """Tell all who listen."""
    for listener in on_compiling:
        listener(begins)
