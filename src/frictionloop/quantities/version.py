"""Which frictionloop this is."""

from __future__ import annotations

from functools import cache
from importlib.metadata import PackageNotFoundError, version


@cache
def package_version() -> str:
    """Return the version of the installed package."""
    try:
        return version("frictionloop")
    except PackageNotFoundError:
        return "0+unknown"
