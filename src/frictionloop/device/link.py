"""Requests and their replies over a pipe, with time-out, repeat and heartbeat; who answers at the other end."""

from __future__ import annotations

import secrets
from collections import deque
from typing import Any, NamedTuple

import numpy as np

from frictionloop.device.codec import REPLIES, Decoder, Message, encode
from frictionloop.device.errors import DeviceError, NoReply, Refused
from frictionloop.device.transport import Pipe
from frictionloop.quantities.protocol_schema import named, schema

REPEAT_S = schema()["protocol"]["repeat_ms"] / 1000
"""Wait so long for a reply before asking again: many times what a frame takes at 2 Mbaud (assumed)."""
ATTEMPTS = schema()["protocol"]["tries"]
"""Ask so often; a second in all (assumed)."""
BEAT_S = schema()["protocol"]["beat_ms"] / 1000
"""Time between heartbeats: four must be lost before the device takes its host for gone."""
INBOX = 4096
"""Messages kept for `poll`; a device that streams to a host that does not listen loses the oldest."""
TELLING = "identify", "heartbeat", "statistics", "get", "hello"
"""What is asked without a session as well: it changes nothing, or begins one."""
NO_INDEX = 65535
REFUSALS = named("refusals")
WORDS = {
    "not_owner": "another host's loop is on",
    "no_session": "session ended; reconnect()",
}
"""What is said of a refusal that is not about what was asked for; of the others their name."""


class Link:
    """One end of the line. Messages that answer nothing (telemetry, faults, late replies) wait for `poll`."""

    def __init__(self, pipe: Pipe) -> None:
        self.pipe, self.decoder = pipe, Decoder()
        self._sequence = secrets.randbelow(2**16)
        self.is_others = False
        """Whether the loop was another host's when it was last asked for: not this one's to switch off unasked."""
        self._session = 0
        """As the device gave it, 0 before the first command: who only looks needs none."""
        self._inbox: deque[Message] = deque(maxlen=INBOX)
        self._spoken = self._heard = pipe.clock()

    def ask(self, name: str, /, **fields: Any) -> Message:
        """Send a request until it is answered, and return the answer.

        Raises
        ------
        Refused
            When the device refuses.
        NoReply
            When nothing comes.
        Unplugged
            When the line is gone.
        """
        if name not in TELLING and not self._session:
            self.greet()
        sequence, frame = self._next(name, fields)
        for _ in range(ATTEMPTS):
            self._send(frame)
            until = self.pipe.clock() + REPEAT_S
            while (left := until - self.pipe.clock()) > 0:
                messages = self._take(left)
                found = [message for message in messages if answers(message, name, sequence, fields)]
                self._inbox.extend(message for message in messages if message not in found)
                if found:
                    return self._answer(found[0], name, fields)
        raise NoReply(f"{name}: no reply in {ATTEMPTS * REPEAT_S:g} s")

    def _answer(self, found: Message, name: str, fields: dict[str, Any]) -> Message:
        try:
            answer = _accepted(found, name, fields)
        except Refused as refused:
            self.is_others = self.is_others or refused.reason == "not_owner"
            raise
        self.is_others = self.is_others and name != "mode"
        return answer

    def greet(self) -> None:
        """Begin a session with a number that no other host has chosen."""
        welcome = self.ask("hello", major=schema()["protocol"]["major"], nonce=secrets.randbits(32))
        self._session = welcome["session"]

    def resume(self) -> None:
        """Go on in the session where the device still knows it; else the next command begins another."""
        try:
            self.ask("heartbeat")
        except Refused:
            self._session = 0

    def poll(self, timeout_s: float) -> list[Message]:
        """Return the messages that have come, waiting up to so long for some; keeps the heart beating."""
        if self.pipe.clock() - self._spoken >= BEAT_S:
            self._send(self._next("heartbeat", {})[1])
        if not self._inbox:
            self._inbox += self._take(min(timeout_s, max(self._spoken + BEAT_S - self.pipe.clock(), 0.0)))
        messages = list(self._inbox)
        self._inbox.clear()
        return messages

    def forget(self, name: str | None = None) -> None:
        """Throw away the messages that wait for `poll`: of a kind, or all."""
        kept = (message for message in self._inbox if name is not None and message.name != name)
        self._inbox = deque(kept, INBOX)

    def listen(self, decimation: int, mask: int) -> Message:
        """Ask for telemetry and return the status then: what is of its tick or before was said to somebody else."""
        self.ask("stream", decimation=decimation, mask=mask)
        status = self.ask("heartbeat")
        new = (message for message in self._inbox if message.name == "telemetry" and is_after(message, status["tick"]))
        self._inbox = deque(new, INBOX)  # samples that came in one piece with the status are ours
        return status

    def reopened(self, pipe: Pipe) -> None:
        """Go on over another pipe to the same device; the sequences and all counts go on as well."""
        self.pipe = pipe
        self.decoder.forget()

    @property
    def silent_s(self) -> float:
        """How long nothing whole has come in."""
        return self.pipe.clock() - self._heard

    def _next(self, name: str, fields: dict[str, Any]) -> tuple[int, bytes]:
        """Return the next frame and its sequence."""
        sequence = self._sequence
        self._sequence = (sequence + 1) % 2**16
        return sequence, encode(name, sequence, 0 if name == "hello" else self._session, **fields)

    def _send(self, frame: bytes) -> None:
        # A zero byte ahead: whatever a bad line left behind ends there and does not take this frame with it.
        self.pipe.write(b"\0" + frame)
        self._spoken = self.pipe.clock()

    def _take(self, timeout_s: float) -> list[Message]:
        """Read once and return what came."""
        messages = self.decoder.feed(self.pipe.read(timeout_s))
        if messages:
            self._heard = self.pipe.clock()
        return messages


def is_after(telemetry: Message, tick: int) -> bool:
    """Return whether the last sample of a frame is of a later tick than this one."""
    samples = telemetry["values"].size // max(int(telemetry["mask"]).bit_count(), 1)
    past = (telemetry["tick"] + (samples - 1) * telemetry["decimation"] - tick) % 2**32
    return bool(0 < past < 2**31)


def answers(message: Message, name: str, sequence: int, asked: dict[str, Any]) -> bool:
    """Return whether a message answers this request, and not an earlier one that was given up."""
    if message.name == "refused":
        return bool(message["sequence"] == sequence)
    if message.name != REPLIES[name]:
        return False
    if message.name in ("done", "welcome"):
        return bool(message["sequence"] == sequence)
    if message.name == "words":
        return bool(message["first"] == asked["first"] and len(message["values"]) == asked["count"])
    return True


def _accepted(message: Message, name: str, fields: dict[str, Any]) -> Message:
    if message.name != "refused":
        return message
    reason = REFUSALS.get(message["reason"], f"reason {message['reason']}")
    index = None if message["index"] == NO_INDEX else int(message["index"])
    given = ", ".join(f"{key} = {value}" for key, value in fields.items() if not isinstance(value, np.ndarray | list))
    where = "" if index is None else f", at {index}"
    asked = f"{name} ({given})" if given else name
    said = WORDS.get(reason, reason.replace("_", " "))
    raise Refused(f"{asked}: the device refuses, {said}{where}", reason, index)


BOARDS, RESETS = named("boards"), named("resets")


class Info(NamedTuple):
    """What a device tells about itself."""

    board: str
    revision: str
    """Version of the firmware, and after ``+`` the checksum of its sources (`device.revision`)."""
    serial: int
    """Serial number of the board, 0 where it has none."""
    law: str
    """Kind of the control law that the image has beside the lookup."""
    law_hash: int
    """CRC-32 of its C."""
    tick_hz: int
    version: str
    """Of the protocol."""
    table_hash: int
    waveform: int
    """Points of a set-point table at most."""
    reset: str
    """What its last reset came from."""


def identified(link: Link, address: str) -> Info:
    """Return who answers.

    Raises
    ------
    DeviceError
        When nothing there speaks the protocol, or another major version of it.
    """
    try:
        told = link.ask("identify").fields
    except NoReply:
        raise NoReply(f"{address}: no answer in frictionloop's protocol", "NO-DEVICE") from None
    major = schema()["protocol"]["major"]
    if told["major"] != major:
        raise DeviceError(f"{address}: protocol {told['major']}.{told['minor']}, must be {major}.x", "NO-DEVICE")
    return Info(
        BOARDS.get(told["board"], f"board {told['board']}"),
        _text(told["revision"]),
        told["serial"],
        _text(told["law"]),
        told["law_hash"],
        told["tick_hz"],
        f"{told['major']}.{told['minor']}",
        told["table_hash"],
        told["waveform"],
        RESETS.get(told["reset"], f"reset {told['reset']}"),
    )


def _text(padded: bytes) -> str:
    return padded.rstrip(b"\0").decode("ascii", "replace")
