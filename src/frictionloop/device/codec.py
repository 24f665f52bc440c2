"""Messages as bytes: what protocol/frictionloop.toml describes, in frames COBS(header, body, CRC-16) and a zero byte.

What firmware/core/fl_frame.c does, on the host; nothing here is generated.
"""

from __future__ import annotations

import struct
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from frictionloop.quantities.optional_libraries import needed
from frictionloop.quantities.protocol_schema import schema

FORMATS = {"u8": "B", "u16": "H", "u32": "I", "i16": "h", "i32": "i", "f64": "d"}
"""Formats of numbers as `struct` and numpy write them; all little-endian."""
LARGEST_BODY: int = schema()["protocol"]["largest_body"]


class Layout(NamedTuple):
    """How the body of a message is laid out: fixed fields, then perhaps one that is repeated to the end."""

    name: str
    type: int
    codes: dict[str, str]
    """`struct` formats of the fixed fields."""
    body: struct.Struct
    repeated: str
    item: np.dtype[Any] | None

    def pack(self, fields: Mapping[str, Any]) -> bytes:
        """Return the body of a message with these fields, which were looked at where they came from."""
        body = self.body.pack(*(fields[name] for name in self.codes))
        return body if self.item is None else body + np.asarray(fields[self.repeated], self.item).tobytes()

    def unpack(self, body: bytes) -> dict[str, Any] | None:
        """Return the fields of a body, a repeated one as an array, or None where the length is not of this message."""
        rest = len(body) - self.body.size
        if rest < 0 or (rest if self.item is None else rest % self.item.itemsize):
            return None
        fields: dict[str, Any] = dict(zip(self.codes, self.body.unpack_from(body), strict=True))
        if self.item is not None:
            fields[self.repeated] = np.frombuffer(body, self.item, offset=self.body.size)
        return fields


def _layout(entry: Mapping[str, Any]) -> Layout:
    fields = entry.get("fields", [])
    fixed = [field for field in fields if not field.get("repeated")]
    repeated = [field for field in fields if field.get("repeated")]
    assert fields == fixed + repeated, "a repeated field ends it"
    assert len(repeated) <= 1, "one repeated field at most"
    codes = {
        field["name"]: f"{field['length']}s" if field["format"] == "bytes" else FORMATS[field["format"]]
        for field in fixed
    }
    return Layout(
        entry["name"],
        entry["type"],
        codes,
        struct.Struct("<" + "".join(codes.values())),
        repeated[0]["name"] if repeated else "",
        np.dtype("<" + FORMATS[repeated[0]["format"]]) if repeated else None,
    )


HEADER = struct.Struct("<" + "".join(FORMATS[field["format"]] for field in schema()["header"]))
"""Type, sequence and stamp."""
LAYOUTS: dict[str, Layout] = {entry["name"]: _layout(entry) for entry in schema()["message"]}
"""By name."""
TYPES: dict[int, Layout] = {layout.type: layout for layout in LAYOUTS.values()}
"""By number."""
REPLIES: dict[str, str] = {entry["name"]: entry["reply"] for entry in schema()["message"] if "reply" in entry}
"""Which message answers which."""


cobs = needed("cobs.cobs", "cobs")
crc16 = needed("fastcrc.crc16", "fastcrc").ibm_3740

LARGEST_CODED = HEADER.size + LARGEST_BODY + 2 + 2
"""Bytes of the largest frame before its zero byte: with CRC and COBS's byte per 254 begun."""
MAJOR = schema()["protocol"]["major"]
"""Version of the protocol that is spoken here."""
REMEMBERED = 256
"""Frames that are known again when a line repeats them (assumed; 0.8 s of telemetry)."""


@dataclass(frozen=True, slots=True, eq=False)
class Message:
    """What a frame says; ``message["tick"]`` is its field of that name."""

    name: str
    sequence: int
    stamp: int
    """The device's microseconds when it sent the frame, modulo 2^32; of a host its session."""
    fields: dict[str, Any]

    def __getitem__(self, name: str) -> Any:
        """Return a field by its name."""
        return self.fields[name]


def encode(name: str, sequence: int, stamp: int = 0, /, **fields: Any) -> bytes:
    """Return the frame of a message, with its zero byte.

    Parameters
    ----------
    name : str
        Of the message, as in protocol/frictionloop.toml.
    sequence : int
        Number of the frame, 0 to 65535.
    stamp : int
        The host's session, 0 without one; from a device its microseconds.
    **fields
        Its fields, whole numbers or bytes; of a repeated one a list or array.
    """
    return framed(HEADER.pack(LAYOUTS[name].type, sequence, stamp) + LAYOUTS[name].pack(fields))


def framed(content: bytes) -> bytes:
    """Return the frame of header and body."""
    return bytes(cobs.encode(content + crc16(content).to_bytes(2, "little"))) + b"\0"


class Decoder:
    """Takes bytes as they come, whole frames or parts; finds itself again at the next zero byte after any junk."""

    def __init__(self) -> None:
        self.whole = 0
        """Frames accepted."""
        self.broken = 0
        """Frames with a wrong code, CRC, type or length."""
        self.missed = 0
        """Frames that the sender's sequence says are missing."""
        self.repeated = 0
        """Frames that came again and were passed over."""
        self.restarts = 0
        """Times the sequence went back: the sender began anew."""
        self._begun = bytearray()
        self._too_long = False
        self._seen: OrderedDict[bytes, None] = OrderedDict()
        self._last: int | None = None

    def feed(self, data: bytes) -> list[Message]:
        """Return the messages that these bytes complete."""
        *ended, rest = data.split(b"\0")
        messages = []
        for part in ended:
            coded = bytes(self._begun) + part if self._begun else part
            self._begun.clear()
            if self._too_long:
                self._too_long = False
                self.broken += 1
            elif coded and (message := self._message(coded)) is not None:
                messages.append(message)
        self._wait_for(rest)
        return messages

    def forget(self) -> None:
        """Forget the frame that has begun: the line was cut there."""
        self.broken += bool(self._begun or self._too_long)
        self._begun.clear()
        self._too_long = False

    def _wait_for(self, rest: bytes) -> None:
        if not self._too_long:
            self._begun += rest
        if len(self._begun) > LARGEST_CODED:  # no frame: wait for the next zero byte with nothing in hand
            self._begun.clear()
            self._too_long = True

    def _message(self, coded: bytes) -> Message | None:
        content = uncoded(coded) if len(coded) <= LARGEST_CODED else None
        kind = None if content is None else TYPES.get(content[0])
        fields = None if content is None or kind is None else _fields(kind, content[HEADER.size :])
        if content is None or kind is None or fields is None:
            self.broken += 1
            return None
        _, sequence, stamp = HEADER.unpack_from(content)
        return Message(kind.name, sequence, stamp, fields) if self._is_new(sequence, coded) else None

    def _is_new(self, sequence: int, coded: bytes) -> bool:
        """Count what is missing before this frame; say no to one that came before, byte by byte the same."""
        if coded in self._seen:
            self.repeated += 1
            return False
        self._seen[coded] = None
        if len(self._seen) > REMEMBERED:
            self._seen.popitem(last=False)
        if self._last is not None:
            step = (sequence - self._last) % 2**16
            if 0 < step < 2**15:
                self.missed += step - 1
            else:
                self.restarts += 1
        self._last = sequence
        self.whole += 1
        return True


def _fields(kind: Layout, body: bytes) -> dict[str, Any] | None:
    """Return the fields of a body; of an identity of another major version the version alone, in whatever length."""
    if kind.name == "identity" and len(body) >= 2 and body[0] != MAJOR:
        return {"major": body[0], "minor": body[1]}
    return kind.unpack(body)


def uncoded(coded: bytes) -> bytes | None:
    """Return header and body of a frame without its zero byte, None where it is broken."""
    try:
        content = bytes(cobs.decode(coded))
    except cobs.DecodeError:
        return None
    content, check = content[:-2], content[-2:]
    if len(content) < HEADER.size or crc16(content) != int.from_bytes(check, "little"):
        return None
    return content
