"""Libraries of the extras, imported where they are used."""

from __future__ import annotations

import importlib
from typing import Any

from frictionloop.quantities import FrictionloopError

PIP = ".venv/bin/pip install --constraint requirements/lock.txt --editable '.[{}]'"
"""The line that installs extras into a clone, with the versions that everything was tested with (README.md)."""
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
