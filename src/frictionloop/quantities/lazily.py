"""Public names that are imported when first used, so that importing a room stays quick."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping
from typing import Any


def lazily(room: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """Return a module's ``__getattr__``: the names of ``homes``, blanks between, each from its module in the room.

    A module that begins with a dot is one of another room, as in ``from ..hardware.plate import answers``.
    """
    places = {name: module for module, names in homes.items() for name in names.split()}

    def get(name: str) -> Any:
        if name not in places:
            raise AttributeError(f"module {room!r} has no attribute {name!r}")
        value = getattr(importlib.import_module(f".{places[name]}", room), name)
        setattr(sys.modules[room], name, value)
        return value

    return get
