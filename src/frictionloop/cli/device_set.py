"""``frictionloop device set``: parameters of a device by name, gains among them, as long as they hold."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import flags, screen
from frictionloop.cli.device import SameAddress

ARGUMENTS = "ADDRESS NAME=VALUE... [--system FILE]"
EXAMPLES = (
    "sim: controller.kp=0.05 controller.ki=100",
    "sim: drive.ceiling_um=2 setpoint.hold_n=0.5",
    "serial:///dev/ttyACM0 --system my-controller.toml",
)


def command(
    address: SameAddress,
    /,
    *assignments: Annotated[flags.Described[str], Parameter(name="NAME=VALUE")],
    system: flags.Described[Path | None] = None,
    unchecked: flags.Described[flags.Flag] = False,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Set parameters of a device, all at once; if one is wrong, none is. A reset forgets them.

    Refused while another host's loop is on.

    Parameters
    ----------
    assignments
        A parameter and its value: of the table, such as drive.ceiling_um=2, or of the controller, such as
        controller.kp=0.05.
    system
        Set the whole table from this system (.toml), and the values given on top. Without it a board tells the gains
        of law pi alone, and no analysis says whether new ones hold.
    unchecked
        Set gains that by analysis do not hold too.
    """
    values = _pairs(assignments)
    if not values and system is None:
        raise fl.FrictionloopError("set: needs NAME=VALUE or --system FILE")
    given = flags.system_given(system, None, None) if system is not None else None
    with fl.progress.waiting(f"connecting {address}"):
        found = fl.device.configure(address, values, given.system if given else None, unchecked=unchecked)
    shown.show(found.with_findings(given.findings if given else ()))


def _pairs(assignments: Iterable[str]) -> dict[str, Any]:
    pairs: dict[str, Any] = {}
    for text in assignments:
        name, _, value = text.partition("=")
        if not name or not value:
            raise fl.FrictionloopError(f"{text!r}: must be NAME=VALUE, such as controller.kp=0.05")
        if name in pairs:
            raise fl.FrictionloopError(f"{name} = {value}: is given twice")
        pairs[name] = flags.scalar(value)
    return pairs
