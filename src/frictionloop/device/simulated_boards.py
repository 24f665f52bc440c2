"""Boards at a simulated bench: the firmware as a library of this machine, or the image that would be flashed."""

from __future__ import annotations

import itertools
import math
import os
from collections import deque
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from frictionloop.control.law import Law
from frictionloop.control.laws import law_of
from frictionloop.device.emulator import TeensyEmulator
from frictionloop.device.errors import DeviceError, Unplugged
from frictionloop.firmware.build_identity import other_sources, revision_here
from frictionloop.firmware.compiled_core import host_library, law_of_table, tick_hz
from frictionloop.firmware.image import FLASHED
from frictionloop.firmware.parameter_words import firmware_words, n_per_count
from frictionloop.loop.stepper import Movement, Stepper
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError, flat_tuples, must_be
from frictionloop.quantities.protocol_schema import schema, word_count
from frictionloop.sensing.measurement import Measurement

TICK_HZ: float = schema()["protocol"]["tick_hz"]
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
    words : array (word_count,)
        Parameter table in force at the start (firmware/parameter_words).
    law : Law, optional
        That it is built with, by default that of the table.
    rate_hz : float
        Of its ticks.
    serial : int
        Serial number that it tells, 0 to 2**32 - 1.
    library : Path, optional
        The firmware as a library, built from this checkout by default.

    reset : int
        What it tells that its last reset came from: a number of the schema's ``resets``.
    """

    def __init__(
        self,
        words: np.ndarray,
        law: Law | None = None,
        rate_hz: float = TICK_HZ,
        serial: int = 0,
        library: Path | None = None,
        reset: int = 0,
    ) -> None:
        table = np.ascontiguousarray(words, dtype=float)
        if table.shape != (word_count(),):
            raise must_be("words: shape", table.shape, f"({word_count()},)")
        self.law = law or law_of_table(table)
        self._ffi, self._lib = host_library(self.law, rate_hz, built=library)
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
        return Drive(drive.duty, drive.amplitude)

    def last(self) -> np.ndarray:
        """Return what the last tick had: measurement, set-point, u, saturated, amplitude (um), and the law's state."""
        numbers = np.zeros(len(Measurement._fields) + 4 + flat_tuples.size(self.law.state))
        self._lib.fl_host_last(self._app, self._ffi.from_buffer("double[]", numbers))
        return numbers

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
        controller = system.controller
        self._board, self._now_us = HostBoard(firmware_words(system), law_of(controller), controller.rate_hz), 0
        self._tick_us = 1_000_000 // tick_hz(controller.rate_hz)

    def tick(self, sample: Sample) -> float:
        """Run a tick; return the amplitude command in um."""
        self._now_us += self._tick_us
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
    """An emulated Teensy 4.1 with its converters on a bench; errors say so if the image is of other sources than these.

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


LISTEN_TICKS = 8
"""The background of a simulated board takes and gives bytes every so many ticks (assumed; 1.6 ms at 5 kHz)."""
REMEMBERED = 300_000
"""Ticks of which the force on the finger is remembered until somebody asks: many times what a run leaves."""
ENDS = -(2**15), 2**15 - 1
"""Of a converter: 16 bit."""


class BenchPipe:
    """The line to a board at a simulated bench, a `Pipe`.

    Plate, friction, finger and sensors are the System's; its controller runs on the board.
    """

    def __init__(self, board: Board, system: System, seed: int = 0) -> None:
        self.board, self.source = board, board.source
        self.system: System | None = system
        self._bench, self._ticks, self._open = Stepper(system, seed), 0, False
        self._converters, self._tick_hz = Converters(system), tick_hz(system.controller.rate_hz)
        self._felt: deque[float] = deque()
        self._felt_from = 0
        self.moves: deque[Movement] | None = None
        """Where the finger is at each tick to come, for a finger that somebody moves; it rests where they end."""
        self._moved = Movement(0.0, 0.0, 0.0)

    def opened(self) -> BenchPipe:
        """Return the line, open; the board is as it was left."""
        self._open = True
        return self

    def read(self, timeout_s: float) -> bytes:
        """Let simulated time pass until the board says something, or for so long."""
        self._check()
        until = self._ticks + max(round(timeout_s * self._tick_hz), 1)
        while True:
            if sent := self.board.transmit():
                return sent
            if self._ticks >= until:
                return b""
            for _ in range(min(LISTEN_TICKS, until - self._ticks)):
                self._tick()

    def write(self, data: bytes) -> None:
        """Give the board bytes."""
        self._check()
        self.board.receive(data)
        self._tick()  # a frame takes its time on the line; what it asks for is in force with the next tick

    def close(self) -> None:
        """Let go of the board; its time stands still until somebody reads again."""
        self._open = False

    def clock(self) -> float:
        """Return simulated time in s."""
        return self._ticks / self._tick_hz

    def felt(self, first_tick: int, count: int, every: int) -> np.ndarray:
        """Return the friction force on the finger in N at ticks of the board, which no sensor shows.

        What was before the first of them is forgotten.
        """
        first = first_tick - 1  # the firmware counts its first tick as 1
        while self._felt and self._felt_from < first:
            self._felt.popleft()
            self._felt_from += 1
        ticks = first + every * np.arange(count) - self._felt_from
        force = np.full(count, np.nan)
        there = (ticks >= 0) & (ticks < len(self._felt))
        last = int(ticks[there][-1]) + 1 if there.any() else 0
        force[there] = np.fromiter(itertools.islice(self._felt, last), float)[ticks[there]]
        return force

    def _tick(self) -> None:
        bench = self._bench
        before = bench.force_n
        command = self.board.tick(self._converters.sample(bench.measured))
        try:
            bench.tick(command, self._movement())
        except FrictionloopError as over:
            raise DeviceError(f"simulated bench: {over}") from None
        self._felt.append(before if bench.tells_sampled else bench.force_n)
        if len(self._felt) > REMEMBERED:
            self._felt.popleft()
            self._felt_from += 1
        self._ticks += 1

    def _movement(self) -> Movement | None:
        if self.moves is None:
            return None
        self._moved = self.moves.popleft() if self.moves else self._moved._replace(speed_m_s=0.0)
        return self._moved

    def _check(self) -> None:
        if not self._open:
            raise Unplugged("simulated board: line closed")


class Converters:
    """The wiring that ``system.board`` describes, the other way round: what the firmware makes of it is what was there.

    The force comes on the first channel, and on the second none.
    """

    def __init__(self, system: System) -> None:
        board = self._board = system.board
        self._force_n = n_per_count(system)
        self._scales = board.position_m_per_count, board.load_n_per_count

    def sample(self, measured: Measurement) -> Sample:
        """Return the counts of a tick, at an end of the converter where a reading does not fit."""
        along, across = self._board.force_zero_counts
        position, load = self._scales
        return Sample(
            _counts(measured.force, self._force_n, along),
            across,
            _counts(measured.position, position, 0),
            _counts(measured.load, load, self._board.load_zero_counts),
        )


def _counts(value: float, unit: float, zero: int) -> int:
    return min(max(zero + round(value / unit), ENDS[0]), ENDS[1]) if unit else zero
