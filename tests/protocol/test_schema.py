"""What is made from the schema is as the schema says."""

from __future__ import annotations

import importlib.util
import re

from frictionloop.device.layout import HEADER, LARGEST_BODY
from frictionloop.quantities.schema import firmware_folder, parameter_words, schema, schema_path

ROOT = schema_path().parents[1]


def test_the_headers_are_up_to_date() -> None:
    spec = importlib.util.spec_from_file_location("generate", schema_path().with_name("generate.py"))
    generate = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(generate)
    core = firmware_folder() / "core"
    assert (core / "fl_protocol.h").read_text(encoding="utf-8") == generate.header()
    assert (core / "fl_duty.h").read_text(encoding="utf-8") == generate.duties()


def test_sizes_that_c_writes_by_hand() -> None:
    text = (firmware_folder() / "core" / "fl_frame.h").read_text(encoding="utf-8")
    assert f"FL_HEADER = {HEADER.size}," in text
    fixed = {"u8": 1, "u16": 2, "u32": 4, "i16": 2, "i32": 4}
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
    assert told["no_finger"]["step"] == 1 / protocol["tick_hz"]
    assert told["force_range"]["step"] == 2.0**-28
    assert 4 * protocol["beat_ms"] < protocol["silence_ms"]
    assert set(told) <= set(schema()["faults"])


def test_the_frame_shown_is_whole(page: str) -> None:
    shown, sent = re.search(r"header and body `([\w ]+)` and is sent as `([\w ]+)`", page).groups()
    from frictionloop.device.codec import framed

    assert framed(bytes.fromhex(shown)) == bytes.fromhex(sent)
