"""Messages to bytes and back, by the schema; the same bytes from Python and from C."""

from __future__ import annotations

import struct
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionloop import FrictionloopError
from frictionloop.device.codec import HEADER, LARGEST_CODED, LAYOUTS, REPLIES, TYPES, Decoder, encode, framed, uncoded
from frictionloop.quantities.optional_libraries import needed
from frictionloop.quantities.protocol_schema import schema

NUMBERS = {
    "u8": st.integers(0, 2**8 - 1),
    "u16": st.integers(0, 2**16 - 1),
    "u32": st.integers(0, 2**32 - 1),
    "i16": st.integers(-(2**15), 2**15 - 1),
    "i32": st.integers(-(2**31), 2**31 - 1),
    "f64": st.floats(allow_nan=False),
}

MAJOR = schema()["protocol"]["major"]


def field(entry: dict[str, Any]) -> st.SearchStrategy[Any]:
    if entry["format"] == "bytes":
        return st.binary(min_size=entry["length"], max_size=entry["length"])
    one = NUMBERS[entry["format"]]
    return st.lists(one, max_size=32) if entry.get("repeated") else one


@st.composite
def messages(draw: st.DrawFn) -> tuple[str, int, int, dict[str, Any]]:
    entry = draw(st.sampled_from(schema()["message"]))
    fields = {each["name"]: draw(field(each)) for each in entry.get("fields", [])}
    if entry["name"] == "identity":
        fields["major"] = MAJOR
    return entry["name"], draw(NUMBERS["u16"]), draw(NUMBERS["u32"]), fields


def by_hand(name: str, sequence: int, stamp: int, fields: dict[str, Any]) -> bytes:
    """Header and body, one field after the other."""
    entry = next(entry for entry in schema()["message"] if entry["name"] == name)
    content = struct.pack("<BHI", entry["type"], sequence, stamp)
    for each in entry.get("fields", []):
        value = fields[each["name"]]
        if each["format"] == "bytes":
            content += value
            continue
        size, signed = int(each["format"][1:]) // 8, each["format"][0] == "i"
        for number in value if each.get("repeated") else [value]:
            whole = each["format"] != "f64"
            content += number.to_bytes(size, "little", signed=signed) if whole else struct.pack("<d", number)
    return content


@given(messages(), st.integers(1, 300))
def test_a_message_comes_back_however_it_is_cut(message: Any, cut: int) -> None:
    name, sequence, stamp, fields = message
    frame = encode(name, sequence, stamp, **fields)
    decoder, found = Decoder(), []
    for start in range(0, len(frame), cut):
        found += decoder.feed(frame[start : start + cut])
    (back,) = found
    assert (back.name, back.sequence, back.stamp) == (name, sequence, stamp)
    assert {
        key: value if isinstance(value, bytes) else np.asarray(value).tolist() for key, value in back.fields.items()
    } == fields
    assert (decoder.whole, decoder.broken, decoder.missed) == (1, 0, 0)


@pytest.mark.parametrize("size", [2, 38, LAYOUTS["identity"].body.size, 60, 272])
def test_of_an_identity_of_another_version_only_the_version_is_read(size: int) -> None:
    body = bytes([MAJOR - 1, 7]).ljust(size, b"\5")
    decoder = Decoder()
    (told,) = decoder.feed(framed(HEADER.pack(LAYOUTS["identity"].type, 1, 2) + body))
    assert (told.name, told.fields, decoder.broken) == ("identity", {"major": MAJOR - 1, "minor": 7}, 0)


def test_an_identity_of_this_version_has_its_length() -> None:
    decoder = Decoder()
    assert decoder.feed(framed(HEADER.pack(LAYOUTS["identity"].type, 1, 2) + bytes([MAJOR, 0]))) == []
    assert decoder.broken == 1


@given(messages())
def test_python_and_c_make_the_same_bytes(core: Any, message: Any) -> None:
    content = by_hand(*message)
    name, sequence, stamp, fields = message
    frame = encode(name, sequence, stamp, **fields)
    assert core.encoded(content) == frame
    assert core.decoded(frame) == ([content], 0)


@given(st.binary(max_size=400).map(lambda junk: junk.replace(b"\0", b"\1")))
def test_python_and_c_accept_and_refuse_the_same(core: Any, junk: bytes) -> None:
    frames = core.decoded(junk + b"\0")[0]
    assert [uncoded(junk)] == (frames or [None])


def test_every_request_names_a_reply_that_exists() -> None:
    asked = [entry["name"] for entry in schema()["message"] if entry["to"] == "device"]
    assert sorted(asked) == sorted(REPLIES)
    assert set(REPLIES.values()) <= set(LAYOUTS)
    assert len(TYPES) == len(LAYOUTS) == len(schema()["message"])


def status(sequence: int, tick: int = 0) -> bytes:
    return encode("status", sequence, 7, state=0, fault=0, tick=tick, commits=0, reset=1)


def test_gaps_repeats_and_restarts_of_the_sequence_are_counted() -> None:
    decoder = Decoder()
    found = decoder.feed(
        status(65534) + status(65535) + status(2) + status(2) + status(65535) + status(3) + status(0, 9)
    )
    assert [message.sequence for message in found] == [65534, 65535, 2, 3, 0]
    assert (decoder.missed, decoder.repeated, decoder.restarts, decoder.broken) == (2, 2, 1, 0)


def test_an_unknown_type_or_a_wrong_length_is_broken() -> None:
    decoder = Decoder()
    assert not decoder.feed(framed(struct.pack("<BHI", 200, 0, 0)))
    assert not decoder.feed(framed(struct.pack("<BHIB", LAYOUTS["status"].type, 0, 0, 0)))
    assert decoder.broken == 2


def test_what_has_no_end_takes_no_room() -> None:
    decoder = Decoder()
    for _ in range(1000):
        decoder.feed(b"\x55" * 1000)
        assert len(decoder._begun) <= LARGEST_CODED
    assert [message.name for message in decoder.feed(b"\0" + status(1))] == ["status"]
    assert decoder.broken == 1


def test_a_missing_library_is_named_with_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cobs.cobs", None)
    with pytest.raises(
        FrictionloopError,
        match=r"^cobs is missing; install with: pip install 'frictionloop\[device\]'$",
    ):
        needed("cobs.cobs", "cobs")
