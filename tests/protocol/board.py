"""A board made of Python that says what the schema says, and the line to it.

Its telemetry is a known function of the tick, so that a wrong value shows.
"""

from __future__ import annotations

import random
import zlib
from typing import Any

import numpy as np

from frictionloop.device.codec import Decoder, Message, encode
from frictionloop.device.errors import Unplugged
from frictionloop.device.transport import Pipe
from frictionloop.quantities.protocol_schema import schema, table_hash, word_count

SAMPLES = 16
POINTS = 1024  # of a set-point table, as in firmware/core/fl_app.h
STATES, REFUSALS, FAULTS = (schema()[group] for group in ("states", "refusals", "faults"))


class Board:
    """Streams 16 samples a frame at 5 kHz and answers; a host that is silent for 200 ms is a fault."""

    def __init__(self, major: int = schema()["protocol"]["major"], hash_of_table: int | None = None) -> None:
        self.tick, self.state, self.fault, self.heard = 1000, STATES["idle"], 0, 1000
        self.decimation, self.next, self.sequence = 0, 0, 0
        self.words, self.waiting = np.zeros(word_count()), np.zeros(word_count())
        self.points, self.played = np.zeros(POINTS, np.int16), None
        self.major, self.hash = major, table_hash() if hash_of_table is None else hash_of_table
        self.decoder, self.out = Decoder(), []
        self.commits, self.session = 0, 0
        self.since = 0  # tick of the last change of state that was asked for

    def values(self, ticks: np.ndarray, state: int) -> np.ndarray:
        """Return the samples at ticks, (ticks, 8)."""
        mixed = (ticks[:, None] * 2654435761 + np.arange(8) * 40503 + 12345) >> 5
        samples = (mixed % 65521 - 32760).astype(np.int16)
        samples[:, 7] = state << 2 | 1 | (samples[:, 0] & 1) << 1
        return samples

    def advance(self, ticks: int) -> None:
        """Let time pass."""
        self.tick += ticks
        if self.state in (1, 2) and self.tick - self.heard > schema()["protocol"]["silence_ms"] * 5:
            self.raise_fault("host_silent")
        while self.decimation and self.next + SAMPLES * self.decimation <= self.tick:
            ticks_of = self.next + self.decimation * np.arange(SAMPLES)
            values = self.values(ticks_of, self.state).reshape(-1)
            self.say("telemetry", tick=self.next, decimation=self.decimation, mask=255, dropped=0, values=values)
            self.next += SAMPLES * self.decimation

    def raise_fault(self, name: str) -> None:
        self.state, self.fault = STATES["fault"], FAULTS[name]
        self.say("fault", fault=self.fault, tick=self.tick, value=7.0)

    def say(self, name: str, **fields: Any) -> None:
        self.out.append(encode(name, self.sequence, self.tick * 200 % 2**32, **fields))
        self.sequence = (self.sequence + 1) % 2**16

    def receive(self, data: bytes) -> None:
        for message in self.decoder.feed(data):
            self.heard = self.tick
            getattr(self, f"on_{message.name}")(message, message.fields)
        self.decoder._seen.clear()  # what is asked again is answered again

    def done(self, message: Message) -> None:
        self.say("done", sequence=message.sequence)

    def refuse(self, message: Message, reason: str, index: int = 65535) -> None:
        self.say("refused", sequence=message.sequence, reason=REFUSALS[reason], index=index)

    def on_identify(self, message: Message, fields: dict[str, Any]) -> None:
        who = {"major": self.major, "minor": 0, "board": 0, "tick_hz": 5000, "table_hash": self.hash}
        size = {"parameters": word_count(), "waveform": POINTS, "serial": 77, "revision": b"1.2".ljust(16, b"\0")}
        size |= {"law": b"pi".ljust(32, b"\0"), "law_hash": 1, "reset": 1}
        self.say("identity", **who, **size)

    def on_hello(self, message: Message, fields: dict[str, Any]) -> None:
        self.session = fields["nonce"]
        self.say("welcome", sequence=message.sequence, session=self.session)

    def on_get(self, message: Message, fields: dict[str, Any]) -> None:
        first, count = fields["first"], fields["count"]
        self.say("words", first=first, values=self.words[first : first + count])

    def on_set(self, message: Message, fields: dict[str, Any]) -> None:
        first, values = fields["first"], fields["values"]
        self.waiting[first : first + len(values)] = values
        self.done(message)

    def on_commit(self, message: Message, fields: dict[str, Any]) -> None:
        if zlib.crc32(self.waiting.astype("<f8").tobytes()) != fields["crc"]:
            return self.refuse(message, "wrong_crc")
        self.words[:] = self.waiting
        self.commits += 1
        return self.done(message)

    def on_waveform(self, message: Message, fields: dict[str, Any]) -> None:
        first, values = fields["first"], fields["values"]
        self.points[first : first + len(values)] = values
        self.done(message)

    def on_play(self, message: Message, fields: dict[str, Any]) -> None:
        if zlib.crc32(self.points[: fields["count"]].astype("<i2").tobytes()) != fields["crc"]:
            return self.refuse(message, "wrong_crc")
        self.played = fields
        return self.done(message)

    def on_mode(self, message: Message, fields: dict[str, Any]) -> None:
        if self.fault:
            return self.refuse(message, "not_now")
        self.state, self.since = fields["state"], self.tick
        return self.done(message)

    def on_stream(self, message: Message, fields: dict[str, Any]) -> None:
        if fields["decimation"] and not self.decimation:
            self.next = self.tick
        self.decimation = fields["decimation"]
        self.done(message)

    def on_heartbeat(self, message: Message, fields: dict[str, Any]) -> None:
        self.say("status", state=self.state, fault=self.fault, tick=self.tick, commits=self.commits, reset=1)

    def on_clear(self, message: Message, fields: dict[str, Any]) -> None:
        self.state = self.fault = 0
        self.done(message)

    def on_statistics(self, message: Message, fields: dict[str, Any]) -> None:
        counts = dict.fromkeys(("overruns", "frames", "broken", "missed", "dropped"), 3)
        self.say("counted", ticks=self.tick, longest_us=384, **counts)


class Line(Pipe):
    """A line to a board with the board's clock; `spoil` is what it does to the bytes of a frame, None to hold it up."""

    source = "simulated"

    def __init__(self, board: Board, spoil: Any = None) -> None:
        self.board, self.spoil = board, spoil or (lambda frame: frame)
        self.is_open, self.held = True, b""

    def clock(self) -> float:
        return self.board.tick / 5000

    def write(self, data: bytes) -> None:
        self.check()
        self.board.receive(data)

    def read(self, timeout_s: float) -> bytes:
        until = self.board.tick + max(round(timeout_s * 5000), 1)
        while True:
            self.check()
            got = b"".join(self.spoil(frame) for frame in self.board.out)
            self.board.out.clear()
            if got or self.board.tick >= until:
                return got
            self.board.advance(min(SAMPLES, until - self.board.tick))

    def check(self) -> None:
        if not self.is_open:
            raise Unplugged("the line: unplugged")

    def close(self) -> None:
        self.is_open = False


class BadLine(Line):
    """A line that flips, drops and repeats bytes, stalls, and goes away."""

    def __init__(self, board: Board, draw: random.Random) -> None:
        super().__init__(board, self.spoilt)
        self.draw, self.events, self.stalled_to = draw, [], 0

    def write(self, data: bytes) -> None:
        super().write(self.damaged(data))

    def spoilt(self, frame: bytes) -> bytes:
        chance = self.draw.random()
        if chance < 1e-4 and self.board.state == STATES["closed"] and self.board.tick - self.board.since > 500:
            self.events.append("gone")
            self.is_open, self.held = False, b""  # what was under way is lost
            return b""
        if chance < 1e-3 and self.board.tick > self.stalled_to:
            self.events.append("stall")
            self.stalled_to = self.board.tick + self.draw.randrange(5000)
        line = self.held + self.damaged(frame)
        if self.board.tick < self.stalled_to:
            self.held = line
            return b""
        self.held = b""
        return line

    def damaged(self, frame: bytes) -> bytes:
        line, way = bytearray(frame), self.draw.random()
        first = self.draw.randrange(len(line))
        last = self.draw.randrange(first, len(line)) + 1
        if way < 0.005:
            for _ in range(self.draw.randrange(1, 9)):
                line[self.draw.randrange(len(line))] ^= 1 << self.draw.randrange(8)
        elif way < 0.010:
            del line[first:last]
        elif way < 0.015:
            line[first:first] = line[first:last]
        elif way < 0.018:
            line *= 2
        else:
            return frame
        self.events.append("damage")
        return bytes(line)


class Firmware:
    """The C firmware on a made-up finger; what it says is kept as it is before a line spoils it."""

    def __init__(self) -> None:
        from frictionloop import bench
        from frictionloop.device.simulated_boards import HostBoard, Sample
        from frictionloop.firmware.parameter_words import firmware_words

        self.board, self.sample = HostBoard(firmware_words(bench())), Sample
        self.tick, self.state, self.since, self.out, self.begun = 0, STATES["idle"], 0, [], b""
        self.decoder, self.said, self.faults = Decoder(), {}, []

    def receive(self, data: bytes) -> None:
        self.board.receive(data, self.tick * 200)

    def advance(self, ticks: int) -> None:
        """Slide to and fro over 40 mm at 20 mm/s under half a newton, with some noise in it."""
        for _ in range(ticks):
            noise = self.tick * 2654435761 >> 7 & 63
            way = self.tick % 20000
            position = 4 * (way if way < 10000 else 20000 - way)
            force = 6000 + noise + (self.tick >> 3 & 1023)
            self.tick += 1
            self.board.tick(self.sample(force, 0, position + (noise & 7), 3000 + noise), self.tick * 200)
        while sent := self.board.transmit(self.tick * 200):
            *frames, self.begun = (self.begun + sent).split(b"\0")
            self.out += [frame + b"\0" for frame in frames]
            for frame in frames:
                self.keep(self.decoder.feed(frame + b"\0")[0])

    def keep(self, message: Message) -> None:
        if message.name == "fault":
            self.faults.append(message.fields)
        if message.name == "telemetry":
            self.said[message["tick"]] = message["values"]
            self.since = self.since or self.tick
            self.state = int(message["values"][-1]) >> 2 & 3

    def values(self, ticks: np.ndarray, state: int) -> np.ndarray:
        """Return the samples that were said of ticks; none at a tick that was not spoken of."""
        rows = {tick + k: row for tick, values in self.said.items() for k, row in enumerate(values.reshape(-1, 8))}
        return np.array([rows[int(tick)] for tick in ticks])
