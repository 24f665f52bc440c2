"""The whole firmware on this machine: firmware/core behind fl_app.h, called tick by tick."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from frictionloop.firmware.compiled import host_library
from frictionloop.firmware.revision import revision_here
from frictionloop.quantities import must_be
from frictionloop.quantities.schema import schema, word_count

ROOM = 4096
"""Bytes taken from the firmware at once."""


class Sample(NamedTuple):
    """What the converters read at a tick, in counts."""

    force: int = 0
    """First channel, -32768 to 32767."""
    across: int = 0
    """Second channel."""
    position: int = 0
    load: int = 0


class Drive(NamedTuple):
    """What the firmware makes of it."""

    duty: int
    """Of the carrier, in 2^-17."""
    amplitude_um: float
    """Amplitude that the duty stands for."""


class HostBoard:
    """The firmware with this program as its board: it samples, drives, and moves the bytes.

    Parameters
    ----------
    words : array (word_count,) of int32
        Parameter table in force at the start (firmware/parameter_words).
    serial : int
        Serial number that it tells, 0 to 2**32 - 1.
    library : Path, optional
        The firmware as a library, built from this checkout by default.

    reset : int
        What it tells that its last reset came from: a number of the schema's ``resets``.

    Raises
    ------
    FrictionloopError
        For a table of another size, or without a C compiler.
    """

    def __init__(self, words: np.ndarray, serial: int = 0, library: Path | None = None, reset: int = 0) -> None:
        table = np.ascontiguousarray(words, dtype=np.int32)
        if table.shape != (word_count(),):
            raise must_be("words: shape", table.shape, f"({word_count()},)")
        self._ffi, self._lib = host_library(built=library) if library else host_library()
        self._memory = self._ffi.new("uint64_t[]", -(-self._lib.fl_app_size() // 8))
        self._app = self._ffi.cast("fl_app *", self._memory)
        self._revision = self._ffi.new("char[]", revision_here().encode("ascii"))
        identity = self._ffi.new("fl_identity *", (schema()["boards"]["host"], serial, self._revision, reset))
        self._lib.fl_app_start(self._app, identity, self._ffi.from_buffer(table))
        self._sample, self._out = self._ffi.new("fl_sample *"), self._ffi.new("uint8_t[]", ROOM)

    def tick(self, sample: Sample, now_us: int, late: bool = False) -> Drive:
        """Run one tick; ``now_us`` counts on modulo 2^32."""
        given = self._sample
        given.force[0], given.force[1], given.position, given.load = sample
        drive = self._lib.fl_app_tick(self._app, given, now_us % 2**32, late)
        return Drive(drive.duty, drive.amplitude / 2**28)

    def took(self, duration_us: float) -> None:
        """Tell how long the last tick took."""
        self._lib.fl_app_took(self._app, round(duration_us * 256))

    def receive(self, data: bytes, now_us: int) -> None:
        """Give the firmware bytes that came in."""
        self._lib.fl_app_receive(self._app, data, len(data), now_us % 2**32)

    def transmit(self, now_us: int, room: int = ROOM) -> bytes:
        """Return what it has to send, at most ``room`` bytes of it."""
        count = self._lib.fl_app_transmit(self._app, self._out, min(room, ROOM), now_us % 2**32)
        return bytes(self._ffi.buffer(self._out, count))
