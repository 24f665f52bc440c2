"""Tables of the protocol page, made from the schema that host and firmware are made from."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from tables import UNITS, table

from frictionloop.control.laws import BUILT_IN
from frictionloop.device.codec import encode, uncoded
from frictionloop.quantities import flat_tuples
from frictionloop.quantities.protocol_schema import parameter_words, schema, schema_path, table_hash

GROUPS = "boards", "sources", "states", "faults", "resets", "refusals", "steps", "conditions"
FIELDS = "Field", "Format", "Meaning"
FORMATS = {"f64": "number", "count": "whole number"}


def texts() -> dict[str, str]:
    """Return what the page inserts, by name."""
    parts = header(), messages(), bodies(), channels(), words(), example(), hashed(), values(), gains(), start()
    names = "header", "messages", "bodies", "channels", "words", "example", "hashed", "values", "gains", "start"
    found = dict(zip(names, parts, strict=True)) | {group: named(group) for group in GROUPS} | numbers()
    return found | {"effect_fields": effect_fields()}


def numbers() -> dict[str, str]:
    """Return the constants of the protocol as text."""
    rates = ", ".join(map(str, schema()["rates"]["hz"]))
    return {name: str(value) for name, value in schema()["protocol"].items()} | {"rates": rates}


def header() -> str:
    """Return the fields of the header."""
    return table(FIELDS, (_field(entry) for entry in schema()["header"]))


def messages() -> str:
    """Return the list of the messages."""
    rows = (
        (entry["type"], f"`{entry['name']}`", f"to {entry['to']}", _code(entry.get("reply")), entry.get("text", ""))
        for entry in schema()["message"]
    )
    return table(("Type", "Message", "Goes", "Answered by", "Meaning"), rows)


def effect_fields() -> str:
    """Return the fields of a step of an effect."""
    return table(FIELDS, (_field(entry) for entry in schema()["effect_step"]))


def bodies() -> str:
    """Return the fields of each message that has some."""
    with_fields = (entry for entry in schema()["message"] if "fields" in entry)
    return "\n\n".join(
        f"**`{entry['name']}`** (type {entry['type']}, to {entry['to']})\n\n"
        + table(FIELDS, (_field(field) for field in entry["fields"]))
        for entry in with_fields
    )


def named(group: str) -> str:
    """Return numbers, names and meanings of a group; the meanings are the comments beside them in the schema."""
    section = schema_path().read_text(encoding="utf-8").split(f"[{group}]\n")[1].split("\n\n")[0]
    meanings = dict(re.findall(r"^(\w+) = \d+ *(?:# (.*))?$", section, re.MULTILINE))
    rows = ((number, f"`{name}`", meanings[name]) for name, number in schema()[group].items())
    return table(("Number", "Name", "Meaning"), rows)


def channels() -> str:
    """Return the telemetry channels."""
    rows = (
        (bit, f"`{entry['name']}`", _scale(entry), _range(entry), entry["text"])
        for bit, entry in enumerate(schema()["channel"])
    )
    return table(("Bit", "Channel", "One step", "Range", "Meaning"), rows)


def words() -> str:
    """Return the parameter table."""
    rows = (
        (
            _indices(word.first, word.count),
            f"`{word.name}`" + (f" × {word.count}" if word.count > 1 else ""),
            FORMATS[word.format],
            _unit(word.unit),
            f"{word.low:.10g} to {word.high:.10g}",
            word.text,
        )
        for word in parameter_words().values()
    )
    return table(("Words", "Name", "Format", "Unit", "Accepted", "Meaning"), rows)


def example() -> str:
    """Return the bytes of a frame, as they go over the line."""
    frame = encode("mode", 1, state=schema()["states"]["closed"])
    bare = uncoded(frame[:-1]) or b""
    return (
        f"`mode` with `state = 2` as frame 1 has header and body `{bare.hex(' ')}` and is sent as `{frame.hex(' ')}`."
    )


def hashed() -> str:
    """Return the first line that the hash of the parameter table is made of, and the hash."""
    word = next(iter(parameter_words().values()))
    return f"The first line is `{word.name} {word.format} {word.count}`, the hash of all of them `{table_hash():08x}`."


def values() -> str:
    """Return the unit of the value of a fault."""
    rows = ((f"`{name}`", _unit(unit)) for name, unit in schema()["fault_values"].items())
    return table(("Fault", "Unit of `value`"), rows)


def gains() -> str:
    """Return the gains of each built-in law in their order, without the clamp."""
    rows = ((law.kind, _listed(flat_tuples.names(law.gains)[:-2])) for law in BUILT_IN)
    return table(("Law", "`law.gains`"), rows)


def start() -> str:
    """Return the states of each built-in law in their order."""
    return table(("Law", "`law.start`"), ((law.kind, _listed(flat_tuples.names(law.state))) for law in BUILT_IN))


def _listed(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names) or "none"


def _indices(first: int, count: int) -> str:
    return str(first) if count == 1 else f"{first}–{first + count - 1}"


def _field(entry: dict[str, Any]) -> Iterable[str]:
    many = " to the end" if entry.get("repeated") else f" × {entry['length']}" if "length" in entry else ""
    kind = "u8" if entry["format"] == "bytes" else entry["format"]
    return f"`{entry['name']}`", f"{kind}{many}", entry["text"]


def _code(name: str | None) -> str:
    return f"`{name}`" if name else "–"


def _unit(unit: str) -> str:
    return {"um^2": "µm²", **UNITS}.get(unit, unit)


def _scale(entry: dict[str, Any]) -> str:
    return f"{entry['scale']:g} {_unit(entry['unit'])}" if entry["unit"] else "–"


def _range(entry: dict[str, Any]) -> str:
    return f"±{32767 * entry['scale']:.3g} {_unit(entry['unit'])}" if entry["unit"] else "bits"
