"""Write fl_protocol.h from frictionloop.toml, and fl_duty.h, into firmware/core: `python protocol/generate.py`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import groupby

from frictionloop.quantities.protocol_schema import (
    Word,
    firmware_folder,
    parameter_words,
    schema,
    table_hash,
    word_count,
)

NUMBERED = ("boards", "sources", "states", "faults", "resets", "refusals", "steps", "conditions")


def header() -> str:
    """Return the text of the header."""
    return "\n".join([*_top(), *_names(), *_messages(), *_channels(), *_parameters(), "", "#endif", ""])


def duties() -> str:
    """Return the text of fl_duty.h: the carrier's fundamental goes with sin(pi duty), so duty = asin(a/largest)/pi."""
    rows = [round(math.asin(k / 256) / math.pi * 2**17) for k in range(257)]
    lines = [", ".join(map(str, rows[k : k + 12])) for k in range(0, len(rows), 12)]
    return (
        "/* Made by protocol/generate.py. Duty in 2^-17 at 257 amplitudes, from 0 to that of 1/2: asin(share)/pi. */\n"
        "static const int32_t fl_duties[257] = {\n" + "".join(f"    {line},\n" for line in lines) + "};\n"
    )


def _top() -> Iterator[str]:
    protocol = schema()["protocol"]
    yield "/* Made by protocol/generate.py from protocol/frictionloop.toml: change that file. */"
    yield "#ifndef FL_PROTOCOL_H\n#define FL_PROTOCOL_H\n"
    yield "#include <stdint.h>\n"
    for name, value in protocol.items():
        line = f"#define FL_{name.upper()} {value}"
        yield f"#ifndef FL_TICK_HZ /* as the image is built */\n{line}\n#endif" if name == "tick_hz" else line
    yield f"#define FL_TABLE_HASH 0x{table_hash():08x}u"
    yield f"#define FL_WORDS {word_count()}"


def _names() -> Iterator[str]:
    for group in NUMBERED:
        singular = group.rstrip("s")
        names = ", ".join(f"FL_{singular.upper()}_{name.upper()} = {value}" for name, value in schema()[group].items())
        yield f"\nenum fl_{singular} {{ {names} }};"


def _messages() -> Iterator[str]:
    names = ", ".join(f"FL_MESSAGE_{m['name'].upper()} = {m['type']}" for m in schema()["message"])
    yield f"\nenum fl_message {{ {names} }};"


def _channels() -> Iterator[str]:
    names = ", ".join(f"FL_CHANNEL_{channel['name'].upper()}" for channel in schema()["channel"])
    yield f"\nenum fl_channel {{ {names}, FL_CHANNELS }};"


def _parameters() -> Iterator[str]:
    yield "\n/* The parameter table: FL_WORDS words in this order, all doubles. */"
    yield "typedef struct {"
    for word in parameter_words().values():
        yield f"    double {_identifier(word)}{_array(word)};  /* {_meaning(word)} */"
    yield "} fl_parameters;"
    yield "\n/* Least and largest value of parameters, one after the other, and whether they are whole numbers. */"
    yield "typedef struct { uint16_t first, whole; double low, high; } fl_range;"
    ranges = list(_ranges())
    yield f"#define FL_RANGES {len(ranges)}"
    yield "#define FL_RANGE_TABLE { \\"
    yield " \\\n".join(f"    {line}," for line in ranges) + " \\\n}"


def _identifier(word: Word) -> str:
    return word.name.replace(".", "_")


def _array(word: Word) -> str:
    return f"[{word.count}]" if word.count > 1 else ""


def _meaning(word: Word) -> str:
    unit = f", {word.unit}" if word.unit else ""
    return f"{word.format}{unit}: {word.text}"


def _ranges() -> Iterator[str]:
    """Yield the ranges; parameters that follow one another with the same ends share one."""
    for (whole, low, high), words in groupby(parameter_words().values(), _ends):
        yield f"{{{next(iter(words)).first}, {int(whole)}, {float(low)!r}, {float(high)!r}}}"


def _ends(word: Word) -> tuple[bool, float, float]:
    return word.format == "count", word.low, word.high


if __name__ == "__main__":
    core = firmware_folder() / "core"
    (core / "fl_protocol.h").write_text(header(), encoding="utf-8")
    (core / "fl_duty.h").write_text(duties(), encoding="utf-8")
    print(f"{word_count()} words")
