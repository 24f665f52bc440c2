"""The fault that a device stopped with, cleared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from frictionloop.device.addressed import opened
from frictionloop.findings import Result
from frictionloop.findings.result import Row

if TYPE_CHECKING:
    from frictionloop.device.device import Device

LISTEN_S, DECIMATION = 0.1, 50
"""Ten samples of telemetry: the last one tells the fault that is in force."""


@dataclass(frozen=True, kw_only=True)
class Cleared(Result):
    """What was cleared."""

    SCHEMA: ClassVar[str] = "device.clear/1"
    fault: str | None
    """None if there was none."""

    def rows(self) -> list[Row]:
        """Return the fault."""
        return [("cleared", self.fault or "no fault")]


def clear(where: str | Device) -> Cleared:
    """Clear the fault of a device, at an address or connected already.

    Raises
    ------
    FrictionloopError
        While its cause lasts, with the fault's code, and for a device that sends no samples.
    """
    from frictionloop.device.errors import DeviceError, Refused
    from frictionloop.device.fault_codes import fault_error, fault_name
    from frictionloop.device.recorder import fault_of

    with opened(where) as device:
        numbers = [int(fault_of(block["flags"])[-1]) for block in device.stream(LISTEN_S, DECIMATION)]
        if not numbers:
            raise DeviceError(f"{device.address}: sends no samples")
        try:
            device.clear()
        except Refused as refused:
            if refused.reason != "still_at_fault":
                raise
            raise fault_error(numbers[-1], "lasts") from None
    name = fault_name(numbers[-1])
    return Cleared(fault=None if name == "none" else name)
