"""``frictionloop device clear``: out of a fault, with what it was."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from frictionloop.cli import flags, screen
from frictionloop.cli.address import connected
from frictionloop.quantities.units import FrictionloopError

ARGUMENTS = "ADDRESS [--json]"
EXAMPLES = r"""Examples

  frictionloop device clear serial:///dev/ttyACM0
"""
LISTEN_S, DECIMATION = 0.1, 50
"""Ten samples of telemetry: the last one tells the fault that is in force."""


def command(
    address: Annotated[str, Parameter(name="ADDRESS", help="As in device info.", group=flags.SYSTEM)],
    /,
    *,
    json: flags.Json = False,
) -> None:
    """Clear the fault that a device stopped with, and say which it was; refused while its cause lasts."""
    from frictionloop.device.errors import Refused
    from frictionloop.device.recorder import fault_of
    from frictionloop.quantities.schema import schema

    numbers = schema()["faults"]
    with connected(address) as device:
        told = [fault_of(block["flags"])[-1] for block in device.stream(LISTEN_S, DECIMATION)]
        if not told:
            raise FrictionloopError(f"{address}: sends no samples, so its fault is not known")
        fault = next((name for name, number in numbers.items() if number == told[-1]), f"number {told[-1]:g}")
        try:
            device.clear()
        except Refused as refused:
            if refused.reason != "still_at_fault":
                raise
            raise FrictionloopError(f"fault {fault}: its cause lasts; put it right, then clear again") from None
    had = fault if told[-1] != numbers["none"] else None
    if json:
        screen.show_json({"cleared": had})
        return
    screen.show(f"cleared {had}" if had else "no fault")
