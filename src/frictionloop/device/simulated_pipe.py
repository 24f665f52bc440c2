"""The line to a board at a simulated bench: time passes while the host reads, as fast as it computes."""

from __future__ import annotations

import itertools
from collections import deque

import numpy as np

from frictionloop.device.boards import Board
from frictionloop.device.errors import DeviceError, Unplugged
from frictionloop.device.host_board import Sample
from frictionloop.device.pipe import Pipe
from frictionloop.device.recorder import TICK_HZ
from frictionloop.firmware.parameter_words import n_per_count
from frictionloop.loop.stepper import Movement, Stepper
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError
from frictionloop.sensing.measurement import Measurement

LISTEN_TICKS = 8
"""The background of a simulated board takes and gives bytes every so many ticks (assumed: 1.6 ms)."""
REMEMBERED = 60 * TICK_HZ
"""Ticks of which the force on the finger is remembered until somebody asks: a minute, many times what a run leaves."""
ENDS = -(2**15), 2**15 - 1
"""Of a converter: 16 bit."""


class BenchPipe(Pipe):
    """The line to a board at a simulated bench.

    Plate, friction, finger and sensors are the System's; its controller runs on the board.
    """

    def __init__(self, board: Board, system: System, seed: int = 0) -> None:
        self.board, self.system, self.source = board, system, board.source
        self._bench, self._ticks, self._open = Stepper(system, seed), 0, False
        self._converters = Converters(system)
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
        until = self._ticks + max(round(timeout_s * TICK_HZ), 1)
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
        return self._ticks / TICK_HZ

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
