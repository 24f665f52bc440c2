"""Boards of a simulated bench: the firmware as a library of this machine, or the image that would be flashed."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Protocol

from frictionloop.device.emulator import TeensyEmulator
from frictionloop.device.errors import DeviceError
from frictionloop.device.host_board import HostBoard, Sample
from frictionloop.device.recorder import TICK_HZ
from frictionloop.firmware.image import FLASHED
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.firmware.revision import other_sources
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError

TICK_US = 1_000_000 // TICK_HZ


class Board(Protocol):
    """What sits between bench and line: converters in, amplitude out, bytes both ways."""

    source: str
    """As in a run's attributes."""

    def tick(self, sample: Sample) -> float:
        """Run a tick with these counts; return the amplitude command in um."""

    def receive(self, data: bytes) -> None:
        """Take bytes from the line."""

    def transmit(self) -> bytes:
        """Return the bytes for the line."""


class Simulated:
    """The firmware as a library of this machine, set up from a System."""

    source = "simulated"

    def __init__(self, system: System) -> None:
        self._board, self._now_us = HostBoard(firmware_words(system)), 0

    def tick(self, sample: Sample) -> float:
        """Run a tick; return the amplitude command in um."""
        self._now_us += TICK_US
        return self._board.tick(sample, self._now_us).amplitude_um

    def receive(self, data: bytes) -> None:
        """Take bytes from the line."""
        self._board.receive(data, self._now_us)

    def transmit(self) -> bytes:
        """Return the bytes for the line."""
        sent = self._board.transmit(self._now_us)
        while more := self._board.transmit(self._now_us):
            sent += more
        return sent


class Emulated:
    """An emulated Teensy 3.1 with its converters on a bench; errors say so if the image is of other sources than these.

    The plate has its largest amplitude at duty 1/2: the fundamental of the carrier goes with sin(pi duty).
    """

    source = "emulated"

    def __init__(self, image_path: str | os.PathLike[str], largest_um: float) -> None:
        self._image, self._largest_um = _image_of(Path(image_path)), largest_um
        try:
            self._teensy = TeensyEmulator(self._image)
        except FrictionloopError as refused:
            raise FrictionloopError(f"{refused}{other_sources(self._image)}") from None

    def tick(self, sample: Sample) -> float:
        """Run a tick; return the amplitude that the carrier stands for, in um."""
        force, across, position, load = sample
        try:
            duty = self._teensy.tick((force, across), load, position)
        except FrictionloopError as stopped:
            raise DeviceError(f"image stopped: {stopped}{other_sources(self._image)}") from None
        return self._largest_um * math.sin(math.pi * duty)

    def receive(self, data: bytes) -> None:
        """Take bytes from the line."""
        self._teensy.receive(data)

    def transmit(self) -> bytes:
        """Return the bytes for the line."""
        return self._teensy.transmit()


def _image_of(path: Path) -> Path:
    """Return the image at a path: the file, or in a folder that of the board that is emulated."""
    if not path.is_dir():
        return path
    image = path / f"{FLASHED}.elf"
    if not image.is_file():
        raise FrictionloopError(f"{image}: no such file; firmware build makes one", "BAD-IMAGE")
    return image
