"""The bytes of each message, as protocol/frictionloop.toml describes them; nothing here is generated."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from frictionloop.quantities import must_be
from frictionloop.quantities.schema import schema

FORMATS = {"u8": "B", "u16": "H", "u32": "I", "i16": "h", "i32": "i"}
"""Formats of whole numbers as `struct` and numpy write them; all little-endian."""
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
        """Return the body of a message with these fields."""
        names = (*self.codes, self.repeated) if self.repeated else (*self.codes,)
        if set(names) != set(fields):
            raise must_be(f"{self.name}: fields", [*fields], ", ".join(names) or "none")
        body = b"".join(self._fixed(name, fields[name]) for name in self.codes)
        if self.item is not None:
            body += self._repeated(fields[self.repeated], self.item)
        if len(body) > LARGEST_BODY:
            raise must_be(f"{self.name}: body", len(body), f"at most {LARGEST_BODY}", "bytes")
        return body

    def unpack(self, body: bytes) -> dict[str, Any] | None:
        """Return the fields of a body, a repeated one as an array, or None where the length is not of this message."""
        rest = len(body) - self.body.size
        if rest < 0 or (rest if self.item is None else rest % self.item.itemsize):
            return None
        fields: dict[str, Any] = dict(zip(self.codes, self.body.unpack_from(body), strict=True))
        if self.item is not None:
            fields[self.repeated] = np.frombuffer(body, self.item, offset=self.body.size)
        return fields

    def _fixed(self, name: str, value: Any) -> bytes:
        code = f"<{self.codes[name]}"
        with suppress(struct.error, TypeError):
            packed = struct.pack(code, value)
            if struct.unpack(code, packed) == (value,):  # `struct` cuts or fills bytes of another length
                return packed
        raise must_be(f"{self.name}: {name}", value, _taken(code))

    def _repeated(self, values: Any, item: np.dtype[Any]) -> bytes:
        with suppress(OverflowError, TypeError, ValueError):
            given, info = np.asarray(values), np.iinfo(item)
            whole = given.ndim == 1 and (given.dtype.kind in "iu" or not given.size)
            if whole and np.all((given >= info.min) & (given <= info.max)):
                return given.astype(item).tobytes()
        raise must_be(f"{self.name}: {self.repeated}", values, f"whole numbers, {item}")


def _taken(code: str) -> str:
    if code.endswith("s"):
        return f"{code[1:-1]} bytes"
    info = np.iinfo(np.dtype(code))
    return f"a whole number from {info.min} to {info.max}"


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
