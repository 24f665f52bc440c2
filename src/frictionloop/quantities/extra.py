"""Libraries of the extras, imported where they are used."""

from __future__ import annotations

import importlib
from typing import Any

from frictionloop.quantities import FrictionloopError


def needed(module: str, package: str, extra: str = "device") -> Any:
    """Import a module of an extra, or say in one line how to get it."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise FrictionloopError(f"{package} is missing; install it with: pip install 'frictionloop[{extra}]'") from None
