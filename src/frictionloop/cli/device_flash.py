"""``frictionloop device flash``: bring an image onto a Teensy, by PJRC's loader."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import flags, screen

ARGUMENTS = "IMAGE"
EXAMPLES = ("my-image/teensy41.hex",)


def command(
    image: Annotated[flags.Described[Path], Parameter(name="IMAGE")], /, *, shown: screen.Shown = screen.BRIEFLY
) -> None:
    """Flash an image: press the button on the board when asked to.

    Parameters
    ----------
    image
        Intel hex file of `firmware build`.
    """
    with fl.progress.waiting("press the button on the board"):
        found = fl.device.flash(image)
    shown.show(found)
