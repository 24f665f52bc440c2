"""What is made from the schema is as the schema says."""

from __future__ import annotations

import importlib.util
import re
from typing import Any

from frictionloop.device.codec import HEADER, LARGEST_BODY
from frictionloop.quantities.protocol_schema import firmware_folder, parameter_words, schema, schema_path


def test_the_headers_are_up_to_date() -> None:
    spec = importlib.util.spec_from_file_location("generate", schema_path().with_name("generate.py"))
    generate = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(generate)
    core = firmware_folder() / "core"
    assert (core / "fl_protocol.h").read_text(encoding="utf-8") == generate.header()
    assert (core / "fl_duty.h").read_text(encoding="utf-8") == generate.duties()


# What the messages of a major version are: a change of one that is here asks for another major version. One that is
# added asks for another minor version, and is added here.
MAJOR = 5
MESSAGES = {
    "identify": "1:",
    "identity": (
        "2: major u8, minor u8, board u8, tick_hz u32, table_hash u32, parameters u16, waveform u16, "
        "serial u32, revision bytes16, law bytes32, law_hash u32, reset u8"
    ),
    "get": "3: first u16, count u16",
    "words": "4: first u16, values f64*",
    "set": "5: first u16, values f64*",
    "commit": "6: crc u32",
    "waveform": "7: first u16, values i16*",
    "play": "8: source u8, loops u8, count u16, step u32, start_um i32, crc u32",
    "mode": "9: state u8",
    "stream": "10: decimation u16, mask u16",
    "telemetry": "11: tick u32, decimation u16, mask u16, dropped u16, values i16*",
    "heartbeat": "12:",
    "status": "13: state u8, fault u8, tick u32, commits u16, reset u8",
    "clear": "14:",
    "statistics": "15:",
    "counted": "16: ticks u32, overruns u32, longest_us u32, frames u32, broken u32, missed u32, dropped u32",
    "done": "17: sequence u16",
    "refused": "18: sequence u16, reason u8, index u16",
    "fault": "19: fault u8, tick u32, value f64",
    "hello": "20: major u8, nonce u32",
    "welcome": "21: sequence u16, session u32",
    "trigger": "22: number u8",
}


def test_a_message_that_changes_asks_for_another_major_version() -> None:
    is_now = {entry["name"]: laid_out(entry) for entry in schema()["message"]}
    assert schema()["protocol"]["major"] == MAJOR
    assert {name: is_now.get(name) for name in MESSAGES} == MESSAGES


def laid_out(entry: dict[str, Any]) -> str:
    """Return number and fields of a message in a line."""
    fields = (
        f"{field['name']} {field['format']}{field.get('length', '')}{'*' * field.get('repeated', 0)}"
        for field in entry.get("fields", [])
    )
    return f"{entry['type']}: {', '.join(fields)}".rstrip()


def test_sizes_that_c_writes_by_hand() -> None:
    text = (firmware_folder() / "core" / "fl_frame.h").read_text(encoding="utf-8")
    assert f"FL_HEADER = {HEADER.size}," in text
    fixed = {"u8": 1, "u16": 2, "u32": 4, "i16": 2, "i32": 4, "f64": 8}
    for entry in schema()["message"]:
        size = sum(field.get("length") or fixed[field["format"]] for field in entry.get("fields", []))
        assert size <= LARGEST_BODY


def test_the_page_tells_of_everything_in_the_schema(page: str) -> None:
    names = [entry["name"] for kind in ("header", "message", "channel") for entry in schema()[kind]]
    names += [field["name"] for entry in schema()["message"] for field in entry.get("fields", [])]
    names += [name for group in ("boards", "sources", "states", "faults", "refusals") for name in schema()[group]]
    assert [name for name in [*names, *parameter_words()] if f"`{name}`" not in page] == []
    assert "a reading of the force outside safety.force_limit_n for safety.force_ticks" in page


def test_times_in_the_schema_go_with_its_ticks() -> None:
    protocol, told = schema()["protocol"], schema()["fault_values"]
    assert protocol["tick_hz"] in schema()["rates"]["hz"]
    assert all(1_000_000 % rate == 0 and 1000 <= rate <= 20_000 for rate in schema()["rates"]["hz"])
    assert 4 * protocol["beat_ms"] < protocol["silence_ms"]
    assert set(told) <= set(schema()["faults"])


def test_the_frame_shown_is_whole(page: str) -> None:
    shown, sent = re.search(r"header and body `([\w ]+)` and is sent as `([\w ]+)`", page).groups()
    from frictionloop.device.codec import framed

    assert framed(bytes.fromhex(shown)) == bytes.fromhex(sent)
