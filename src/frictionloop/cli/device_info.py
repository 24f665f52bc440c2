"""``frictionloop device info``: who answers, what runs there, and whether its values are those of a file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import flags, screen
from frictionloop.cli.device import Address

ARGUMENTS = "ADDRESS [FILE] [OPTIONS]"
EXAMPLES = (
    "sim:",
    "serial:///dev/ttyACM0 my-controller.toml",
    "emulated:my-image my-controller.toml",
)
Compared = Annotated[
    Path | None,
    Parameter(name="FILE", help="System (.toml) to compare with.", group=flags.SYSTEM),
]


def command(address: Address, file: Compared = None, /, *, shown: screen.Shown = screen.BRIEFLY) -> None:
    """Say who answers at an address, what runs there, with which values, and what it has counted since reset."""
    given = flags.system_given(file, None, None) if file is not None else None
    with fl.progress.waiting(f"connecting {address}"):
        found = fl.device.info(address, given.system if given else None)
    shown.show(found.with_findings(given.findings if given else ()))
