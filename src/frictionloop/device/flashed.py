"""An image onto a Teensy by PJRC's loader, and the instructions that its ticks take."""

from __future__ import annotations

import os
import shutil
import subprocess
from importlib.util import find_spec
from pathlib import Path

from frictionloop.findings import Result
from frictionloop.findings.result import Row
from frictionloop.firmware.image_files import check_teensy, read_hex
from frictionloop.quantities import FrictionloopError, must_be


def instructions(image: str | os.PathLike[str]) -> dict[str, int] | None:
    """Return the instructions of a tick period by what they go to; None without the packages of the emulator.

    ``tick`` is the most that a tick took, ``law`` what was the law's, ``effect`` a tick with the longest effect,
    ``interrupts`` the port's while the line is full both ways, ``background`` the mean of what is done between ticks.
    """
    if not find_spec("unicorn"):
        return None
    from frictionloop.device.emulator import budget

    return budget.traced(image)._asdict()


LOADER = "teensy_loader_cli"
GET_IT = "https://www.pjrc.com/teensy/loader_cli.html"
STDERR = 2
"""Where the loader writes: what is asked of the person is no answer."""


class Flashed(Result, schema="device.flash/1"):
    """An image that a board has."""

    image: str
    flash_bytes: int

    def rows(self) -> list[Row]:
        """Return the image."""
        return [("flashed", f"{self.image}, {self.flash_bytes:,} bytes")]


def flash(image: str | os.PathLike[str]) -> Flashed:
    """Flash the Intel hex file of `firmware.build`; the loader asks for the button on the board.

    Raises
    ------
    FrictionloopError
        For a file that is no image of a Teensy, and a loader that is missing or fails.
    """
    path = Path(image)
    if path.suffix != ".hex" or not path.is_file():
        raise must_be("IMAGE", str(path), "an existing .hex file", code="BAD-IMAGE")
    parts = read_hex(path)
    check_teensy(f"IMAGE = {str(path)!r}", parts)
    loader = shutil.which(LOADER) or shutil.which(LOADER.replace("_", "-"))
    if loader is None:
        raise FrictionloopError(f"{LOADER}: not installed, {GET_IT}")
    done = subprocess.run([loader, "--mcu=TEENSY41", "-w", "-v", str(path)], check=False, stdout=STDERR)
    if done.returncode:
        raise FrictionloopError(f"{LOADER}: exit code {done.returncode}; board plugged in? udev rule?", "NO-DEVICE")
    return Flashed(image=str(path), flash_bytes=sum(len(content) for _, content in parts))
