"""The device at an address that a command was given."""

from __future__ import annotations

from typing import TYPE_CHECKING

from frictionloop.cli import screen

if TYPE_CHECKING:
    from frictionloop.device.device import Device
    from frictionloop.parameters import System


def connected(address: str, system: System | None = None) -> Device:
    """Return the device, as `connect` does; says on a terminal what takes long the first time."""
    here = address.startswith(("sim:", "emulated:"))
    text = "loading the compiled loop and firmware; after an installation they are compiled first"
    with screen.waiting(text if here else f"looking for {address}"):
        from frictionloop.device.device import connect

        return connect(address, system)
