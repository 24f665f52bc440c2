"""The whole firmware on this machine: firmware/core behind fl_app.h, called tick by tick."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from frictionloop.firmware.compiler import shared_library
from frictionloop.firmware.revision import revision_here
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.extra import needed
from frictionloop.quantities.schema import firmware_folder, schema, word_count

DECLARATIONS = """
typedef struct { int32_t force[2]; int32_t position; int32_t load; } fl_sample;
typedef struct { int32_t duty; int32_t amplitude; } fl_drive;
typedef struct { uint8_t board; uint32_t serial; const char *revision; } fl_identity;
typedef struct fl_app fl_app;
size_t fl_app_size(void);
void fl_app_start(fl_app *, const fl_identity *, const void *);
fl_drive fl_app_tick(fl_app *, const fl_sample *, uint32_t, int32_t);
void fl_app_took(fl_app *, uint32_t);
void fl_app_receive(fl_app *, const uint8_t *, size_t, uint32_t);
size_t fl_app_transmit(fl_app *, uint8_t *, size_t, uint32_t);
"""
"""Of firmware/core/fl_app.h; the parameter table is passed as its words."""
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


def core_sources() -> tuple[list[Path], tuple[Path, ...]]:
    """Return the C files of the host library and the folders of their headers."""
    folders = firmware_folder() / "core", firmware_folder() / "boards" / "host"
    return [path for folder in folders for path in sorted(folder.glob("*.c"))], folders


@cache
def load(library: Path | None = None) -> tuple[Any, Any]:
    """Return (ffi, library) of the firmware, compiled at the first call; or of a library that was built otherwise."""
    ffi = needed("cffi", "cffi", "firmware").FFI()
    ffi.cdef(DECLARATIONS)
    sources, folders = core_sources()
    return ffi, ffi.dlopen(str(library or shared_library("core", sources, folders)))


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

    Raises
    ------
    FrictionloopError
        For a table of another size, or without a C compiler.
    """

    def __init__(self, words: np.ndarray, serial: int = 0, library: Path | None = None) -> None:
        table = np.ascontiguousarray(words, dtype=np.int32)
        if table.shape != (word_count(),):
            raise FrictionloopError(f"words: shape {table.shape}; must be ({word_count()},)")
        self._ffi, self._lib = load(library)
        self._memory = self._ffi.new("uint64_t[]", -(-self._lib.fl_app_size() // 8))
        self._app = self._ffi.cast("fl_app *", self._memory)
        self._revision = self._ffi.new("char[]", revision_here().encode("ascii"))
        identity = self._ffi.new("fl_identity *", (schema()["boards"]["host"], serial, self._revision))
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
