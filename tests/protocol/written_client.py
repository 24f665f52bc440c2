"""A client made of nothing but protocol/frictionloop.toml and the tables of docs/protocol.md.

It imports nothing of frictionloop: what it cannot read there, it does not know.
"""

from __future__ import annotations

import re
import secrets
import struct
import tomllib
from collections.abc import Callable
from typing import Any

Table = list[dict[str, str]]


def tables(page: str) -> list[Table]:
    """Return the tables of a page, each a list of rows by the names of the columns."""
    found: list[Table] = []
    for block in re.findall(r"(?:^\|.*\n?)+", page, re.MULTILINE):
        lines = [line[1:-1].split("|") for line in block.replace("`", "").splitlines()]
        head, _, *rows = [[cell.strip() for cell in line] for line in lines]
        found.append([dict(zip(head, row, strict=True)) for row in rows])
    return found


def crc(data: bytes, how: dict[str, str]) -> int:
    """Return a check as its row says, bit by bit."""
    bits, polynomial, value = int(how["Bits"]), int(how["Polynomial"], 16), int(how["Start"], 16)
    for byte in data:
        for k in range(8) if how["Reflected"] == "yes" else range(7, -1, -1):
            top = value >> (bits - 1) ^ byte >> k & 1
            value = value << 1 & (1 << bits) - 1 ^ (polynomial if top else 0)
    if how["Reflected"] == "yes":
        value = int(f"{value:0{bits}b}"[::-1], 2)
    return value ^ (1 << bits) - 1 if how["Inverted at the end"] == "yes" else value


def stuffed(data: bytes) -> bytes:
    """COBS."""
    out = bytearray()
    for part in data.split(b"\0"):
        pieces = [part[k : k + 254] for k in range(0, len(part), 254)] or [b""]
        if len(pieces[-1]) == 254:
            pieces.append(b"")
        for piece in pieces:
            out += bytes([len(piece) + 1]) + piece
    return bytes(out)


def unstuffed(data: bytes) -> bytes:
    out, at = bytearray(), 0
    while at < len(data):
        code = data[at]
        out += data[at + 1 : at + code]
        at += code
        if code < 255 and at < len(data):
            out.append(0)
    return bytes(out)


class Client:
    """Sends what it is asked for over `write`, hears with `read`, and lives by the `clock`, in s."""

    def __init__(
        self,
        schema: str,
        page: str,
        write: Callable[[bytes], None],
        read: Callable[[float], bytes],
        clock: Callable[[], float],
    ) -> None:
        self.schema, self.write, self.read, self.clock = tomllib.loads(schema), write, read, clock
        every = tables(page)
        by_head = {next(iter(table[0])): table for table in every if table}
        self.sizes = {row["Format"]: (int(row["Bytes"]), row["Sign"]) for row in _with(every, "Bytes")}
        self.checks = {row["Check"]: row for row in by_head["Check"]}
        self.times = {row["What"]: row["Value"] for row in by_head["What"]}
        self.steps = [(row["Message"], row["Fields"]) for row in by_head["Step"]]
        self.words = {row["Format"]: int(row["Words"]) for row in _with(every, "Value", "Words", "Format")}
        self.messages = {message["name"]: message for message in self.schema["message"]}
        self.names = {message["type"]: message["name"] for message in self.schema["message"]}
        self.sequence, self.session, self.begun, self.told = secrets.randbelow(2**16), 0, b"", []

    def number(self, what: str) -> int:
        """Return the last whole number of a row of times and sizes."""
        return int(re.findall(r"\d+", self.times[what])[-1])

    def pack(self, form: str, value: float) -> bytes:
        size, sign = self.sizes[form]
        if sign.startswith("IEEE 754"):
            return struct.pack("<d", value)
        return int(value).to_bytes(size, "little", signed=sign != "unsigned")

    def crc32(self, form: str, values: list[float]) -> int:
        return crc(b"".join(self.pack(form, value) for value in values), self.checks["CRC-32"])

    def table_hash(self) -> int:
        lines = [f"{entry['name']} {entry['format']} {entry.get('count', 1)}\n" for entry in self.schema["parameter"]]
        return crc("".join(lines).encode("ascii"), self.checks["CRC-32"])

    def table_words(self) -> int:
        return sum(entry.get("count", 1) * self.words[entry["format"]] for entry in self.schema["parameter"])

    def ask(self, name: str, **fields: Any) -> dict[str, Any]:
        """Send a message until it is answered; return the fields of the answer with its name."""
        self.sequence = (self.sequence + 1) % 2**16
        given = {"type": self.messages[name]["type"], "sequence": self.sequence, "stamp": self.session}
        content = b"".join(self.pack(entry["format"], given[entry["name"]]) for entry in self.schema["header"])
        for field in self.messages[name].get("fields", []):
            values = fields[field["name"]] if field.get("repeated") else [fields[field["name"]]]
            content += b"".join(self.pack(field["format"], value) for value in values)
        frame = stuffed(content + self.pack("u16", crc(content, self.checks["CRC-16"]))) + b"\0"
        for _ in range(self.number("and sends a frame")):
            self.write(b"\0" + frame)
            until = self.clock() + self.number("a host waits for an answer") / 1000
            while (left := until - self.clock()) > 0:
                for answer in self.heard(left):
                    if self.answers(answer, self.messages[name]["reply"]):
                        return answer
        raise TimeoutError(name)

    def answers(self, answer: dict[str, Any], reply: str) -> bool:
        named = "sequence" in [field["name"] for field in self.messages[answer["name"]].get("fields", [])]
        return answer["name"] in (reply, "refused") and (not named or answer["sequence"] == self.sequence)

    def heard(self, timeout_s: float) -> list[dict[str, Any]]:
        *parts, self.begun = (self.begun + self.read(timeout_s)).split(b"\0")
        messages = [message for part in parts if part and (message := self.unpacked(unstuffed(part)))]
        self.told += [message for message in messages if message["name"] in ("telemetry", "fault")]
        return messages

    def unpacked(self, content: bytes) -> dict[str, Any] | None:
        if crc(content[:-2], self.checks["CRC-16"]) != int.from_bytes(content[-2:], "little"):
            return None
        body, message = content[:-2], {}
        for entry in self.schema["header"]:
            message[f"header {entry['name']}"], body = self.taken(entry["format"], body)
        message["name"] = self.names[message["header type"]]
        for field in self.messages[message["name"]].get("fields", []):
            if field["format"] == "bytes":
                message[field["name"]], body = body[: field["length"]], body[field["length"] :]
            elif field.get("repeated"):
                message[field["name"]] = []
                while body:
                    value, body = self.taken(field["format"], body)
                    message[field["name"]].append(value)
            else:
                message[field["name"]], body = self.taken(field["format"], body)
        return message

    def taken(self, form: str, body: bytes) -> tuple[float, bytes]:
        size, sign = self.sizes[form]
        if sign.startswith("IEEE 754"):
            return struct.unpack("<d", body[:size])[0], body[size:]
        return int.from_bytes(body[:size], "little", signed=sign != "unsigned"), body[size:]

    def run(self, table: list[float], points: list[int], duration_s: float) -> None:
        """Do what the page's run says, step by step, with a parameter table and a set-point table."""
        pieces = {"set": (table, "words in set, get and words"), "waveform": (points, "points in waveform")}
        crcs = {"commit": self.crc32("f64", table), "play": self.crc32("i16", points)}
        special = {"major": self.schema["protocol"]["major"], "nonce": secrets.randbits(32), "count": len(points)}
        named = self.schema["sources"] | self.schema["states"]
        for name, text in self.steps:
            if name in pieces:
                values, size = pieces[name]
                for first in range(0, len(values), self.number(size)):
                    self.good(name, first=first, values=values[first : first + self.number(size)])
                continue
            fields = dict(re.findall(r"(\w+) = ([\w ]+)", text))
            given = {key: named.get(value, int(value) if value.isdecimal() else None) for key, value in fields.items()}
            given |= {key: value for key, value in special.items() if key in given}
            if "crc" in given:
                given["crc"] = crcs[name]
            if name != "heartbeat":
                answer = self.good(name, **given)
                self.session = answer.get("session", self.session)
            until = self.clock() + duration_s * (name == "heartbeat")
            while self.clock() < until:
                self.good("heartbeat")
                beat = self.clock() + self.number("a host whose loop is on says something every") / 1000
                while (left := beat - self.clock()) > 0:
                    self.heard(left)

    def good(self, name: str, **fields: Any) -> dict[str, Any]:
        answer = self.ask(name, **fields)
        assert answer["name"] == self.messages[name]["reply"], answer
        return answer


def _with(every: list[Table], *columns: str) -> Table:
    """Return the table that has these columns, and `Format` first."""
    wanted = {"Format", *columns}
    (found,) = [table for table in every if table and next(iter(table[0])) == "Format" and wanted <= set(table[0])]
    return found
