"""``frictionloop device flash``: bring an image onto a Teensy, by PJRC's loader."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from frictionloop.cli import flags, screen
from frictionloop.quantities.units import FrictionloopError

ARGUMENTS = "IMAGE"
EXAMPLES = r"""Examples

  frictionloop firmware build my-controller.toml --out my-image
  frictionloop device flash my-image/teensy31.hex
"""
LOADER = "teensy_loader_cli"
GET_IT = (
    "apt-get install teensy-loader-cli, brew install teensy_loader_cli, or https://www.pjrc.com/teensy/loader_cli.html"
)


def command(image: Annotated[flags.Described[Path], Parameter(name="IMAGE")], /) -> None:
    """Flash an image: press the button on the board when asked to.

    Parameters
    ----------
    image
        Intel hex file of `firmware build`.
    """
    if image.suffix != ".hex":
        raise FrictionloopError(f"IMAGE = {str(image)!r}: must end in .hex; frictionloop firmware build makes one")
    if not image.is_file():
        raise FrictionloopError(f"IMAGE = {str(image)!r}: there is no such file")

    from frictionloop.firmware.image_checks import check_teensy
    from frictionloop.firmware.image_files import read_hex

    check_teensy(f"IMAGE = {str(image)!r}", read_hex(image))
    loader = shutil.which(LOADER) or shutil.which(LOADER.replace("_", "-"))
    if loader is None:
        raise FrictionloopError(f"{LOADER} is not installed: {GET_IT}")
    screen.say("press the button on the board")
    done = subprocess.run([loader, "--mcu=TEENSY31", "-w", "-v", str(image)], check=False)
    if done.returncode:
        raise FrictionloopError(
            f"{LOADER}: ended with {done.returncode}; is the board plugged in, and its udev rule there?"
        )
    screen.show(f"flashed {image}")
