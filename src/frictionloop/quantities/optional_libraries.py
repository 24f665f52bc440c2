"""What is imported when first used: libraries of the extras, and the public names of a room."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping
from typing import Any

from frictionloop.quantities import FrictionloopError


def lazily(room: str, homes: Mapping[str, str]) -> tuple[Callable[[str], Any], list[str], Callable[[], list[str]]]:
    """Return a module's ``__getattr__``, ``__all__`` and ``__dir__``: the names of ``homes``, each from its module.

    Blanks part the names. A module that begins with a dot is one of another room, as in ``from ..hardware.plate import
    answers``.
    """
    places = {name: module for module, names in homes.items() for name in names.split()}

    def get(name: str) -> Any:
        if name not in places:
            raise AttributeError(f"module {room!r} has no attribute {name!r}")
        value = getattr(importlib.import_module(f".{places[name]}", room), name)
        setattr(sys.modules[room], name, value)
        return value

    return get, list(places), lambda: sorted(places)


PIP = "pip install 'frictionloop[{}]'"
"""The line that adds extras, to a package as to a clone that is installed."""
PACKAGES = {
    "cffi": ("cffi", "firmware"),
    "ziglang": ("ziglang", "image"),
    "elftools": ("pyelftools", "image"),
    "unicorn": ("unicorn", "emulator"),
    "cobs": ("cobs", "device"),
    "fastcrc": ("fastcrc", "device"),
    "intelhex": ("intelhex", "device"),
}
"""Package and extra of the modules that verbs with more than one extra need."""


def needed(module: str, package: str, extra: str = "device") -> Any:
    """Import a module of an extra, or say in one line how to get it."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise FrictionloopError(_refusal([package], [extra])) from None


def all_needed(*modules: str) -> None:
    """Refuse in one line what lacks any of some modules of `PACKAGES`, naming all packages and extras at once."""
    missing = []
    for module in modules:
        try:
            importlib.import_module(module)
        except ImportError:
            missing.append(PACKAGES[module])
    if missing:
        packages, extras = zip(*missing, strict=True)
        raise FrictionloopError(_refusal(packages, extras))


def _refusal(packages: Any, extras: Any) -> str:
    are = "is" if len(packages) == 1 else "are"
    return f"{', '.join(packages)} {are} missing; install with: {PIP.format(','.join(dict.fromkeys(extras)))}"
