"""The bytes of each message, as protocol/frictionloop.toml describes them; nothing here is generated."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.schema import schema

FORMATS = {"u8": "B", "u16": "H", "u32": "I", "i16": "h", "i32": "i"}
"""Formats of whole numbers as `struct` and numpy write them; all little-endian."""
LARGEST_BODY: int = schema()["protocol"]["largest_body"]


class Layout(NamedTuple):
    """How the body of a message is laid out: fixed fields, then perhaps one that is repeated to the end."""

    name: str
    type: int
    fixed: tuple[str, ...]
    body: struct.Struct
    repeated: str
    item: np.dtype[Any] | None

    def pack(self, fields: Mapping[str, Any]) -> bytes:
        """Return the body of a message with these fields."""
        names = (*self.fixed, self.repeated) if self.repeated else self.fixed
        if set(names) != set(fields):
            raise FrictionloopError(
                f"{self.name}: fields {', '.join(fields) or 'none'}; must be {', '.join(names) or 'none'}"
            )
        try:
            self._check_lengths(fields)
            body = self.body.pack(*(fields[name] for name in self.fixed)) + self._packed(fields)
        except (struct.error, OverflowError, TypeError, ValueError):
            raise FrictionloopError(f"{self.name}: {self._wrong(fields)}") from None
        if len(body) > LARGEST_BODY:
            raise FrictionloopError(f"{self.name}: {len(body)} bytes; must be at most {LARGEST_BODY}")
        return body

    def unpack(self, body: bytes) -> dict[str, Any] | None:
        """Return the fields of a body, a repeated one as an array, or None where the length is not of this message."""
        rest = len(body) - self.body.size
        if rest < 0 or (rest if self.item is None else rest % self.item.itemsize):
            return None
        fields: dict[str, Any] = dict(zip(self.fixed, self.body.unpack_from(body), strict=True))
        if self.item is not None:
            fields[self.repeated] = np.frombuffer(body, self.item, offset=self.body.size)
        return fields

    def _check_lengths(self, fields: Mapping[str, Any]) -> None:
        """Refuse bytes of another length, which `struct` would cut or fill."""
        for name, code in zip(self.fixed, _codes(self.body.format), strict=True):
            if code.endswith("s") and len(fields[name]) != int(code[:-1]):
                raise ValueError

    def _packed(self, fields: Mapping[str, Any]) -> bytes:
        if self.item is None:
            return b""
        given, info = np.asarray(fields[self.repeated]), np.iinfo(self.item)
        if given.ndim != 1 or (given.size and given.dtype.kind not in "iu"):
            raise ValueError
        if given.size and not info.min <= given.min() <= given.max() <= info.max:
            raise ValueError
        return given.astype(self.item).tobytes()

    def _wrong(self, fields: Mapping[str, Any]) -> str:
        """Return which field does not fit and what it takes."""
        for name, code in zip(self.fixed, _codes(self.body.format), strict=True):
            try:
                if struct.unpack(f"<{code}", struct.pack(f"<{code}", fields[name])) != (fields[name],):
                    raise ValueError
            except (struct.error, TypeError, ValueError):
                return f"{name} = {fields[name]!r}; must be {_taken(code)}"
        return f"{self.repeated} = {fields[self.repeated]!r}; must be whole numbers of {self.item}"


def _codes(form: str) -> list[str]:
    """Return the fields of a `struct` format such as "<BH16s"."""
    codes, digits = [], ""
    for letter in form[1:]:
        if letter.isdigit():
            digits += letter
        else:
            codes.append(digits + letter)
            digits = ""
    return codes


def _taken(code: str) -> str:
    if code.endswith("s"):
        return f"{code[:-1]} bytes"
    info = np.iinfo(np.dtype(f"<{code}"))
    return f"a whole number from {info.min} to {info.max}"


def _layout(entry: Mapping[str, Any]) -> Layout:
    fields = entry.get("fields", [])
    fixed = [field for field in fields if not field.get("repeated")]
    repeated = [field for field in fields if field.get("repeated")]
    assert fields == fixed + repeated, "a repeated field ends its message"
    assert len(repeated) <= 1, "only one field of a message can be repeated"
    codes = (f"{field['length']}s" if field["format"] == "bytes" else FORMATS[field["format"]] for field in fixed)
    return Layout(
        entry["name"],
        entry["type"],
        tuple(field["name"] for field in fixed),
        struct.Struct("<" + "".join(codes)),
        repeated[0]["name"] if repeated else "",
        np.dtype("<" + FORMATS[repeated[0]["format"]]) if repeated else None,
    )


HEADER = struct.Struct("<" + "".join(FORMATS[field["format"]] for field in schema()["header"]))
"""Type, sequence and time_us."""
LAYOUTS: dict[str, Layout] = {entry["name"]: _layout(entry) for entry in schema()["message"]}
"""By name."""
TYPES: dict[int, Layout] = {layout.type: layout for layout in LAYOUTS.values()}
"""By number."""
REPLIES: dict[str, str] = {entry["name"]: entry["reply"] for entry in schema()["message"] if "reply" in entry}
"""Which message answers which."""
