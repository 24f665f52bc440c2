"""A device by its address, for as long as a verb needs it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from frictionloop.quantities.extra import all_needed

if TYPE_CHECKING:
    from frictionloop.device.device import Device
    from frictionloop.parameters import System

NEEDED = {"sim": ("cffi",), "emulated": ("elftools", "unicorn", "intelhex")}
"""Modules that an address takes beside those of the line."""


@contextmanager
def opened(where: str | Device, system: System | None = None, seed: int = 0) -> Iterator[Device]:
    """Yield the device at an address, as `connect` does; one that is connected already as it is, to stay so."""
    if not isinstance(where, str):
        yield where
        return
    scheme = where.partition(":")[0]
    all_needed("cobs", "fastcrc", *NEEDED.get(scheme, ()))
    from frictionloop.device.transport import opener

    opening = opener(where, system, seed)
    # A line that is not there is refused before what drives a device is loaded.
    first = [] if scheme in NEEDED else [opening()]
    from frictionloop.device.device import Device

    with Device(lambda: first.pop() if first else opening(), where) as found:
        yield found
