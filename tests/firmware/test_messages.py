"""Frames as they come: in pieces, together, twice, broken, of the wrong length; and what the board tells by itself."""

from __future__ import annotations

import zlib

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.device.codec import HEADER, LAYOUTS, encode, framed
from frictionloop.firmware.build_identity import revision_here
from frictionloop.firmware.effect_tables import effect_tables
from frictionloop.quantities.protocol_schema import schema, table_hash, word_count
from frictionloop.rendering.effect_setpoint import EffectSource

MAJOR = schema()["protocol"]["major"]


def test_identity(rig):
    told = rig.ask("identify")
    assert (told["major"], told["minor"]) == (MAJOR, schema()["protocol"]["minor"])
    assert (told["board"], told["law"].rstrip(b"\0"), told["tick_hz"]) == (0, b"pi", 5000)
    assert (told["table_hash"], told["parameters"], told["waveform"]) == (table_hash(), word_count(), 1024)
    assert told["revision"].rstrip(b"\0").decode() == revision_here()


def test_every_message_to_the_device_is_answered_as_the_schema_says(rig):
    crc = zlib.crc32(rig.words.astype("<f8").tobytes())
    effect = effect_tables(EffectSource(effect=fl.rendering.Constant()), 255.0).words
    whole = {"count": len(effect), "crc": zlib.crc32(effect.astype("<i2").tobytes())}
    fields = {
        "get": {"first": 0, "count": 1},
        "set": {"first": 0, "values": rig.words[:1]},
        "commit": {"crc": crc},
        "waveform": {"first": 0, "values": effect},
        "play": {"source": 3, "loops": 0, "step": 0, "start_um": 0, **whole},
        "mode": {"state": 0},
        "stream": {"decimation": 0, "mask": 0},
        "hello": {"major": MAJOR, "nonce": 5},
        "trigger": {"number": 255},
    }
    asked = [message for message in schema()["message"] if message["to"] == "device"]
    for message in asked:
        answer = rig.ask(message["name"], **fields.get(message["name"], {}))
        assert answer.name == message["reply"]
        rig.session = answer["session"] if answer.name == "welcome" else rig.session
        rig.tick()


def test_two_frames_at_once_and_a_frame_in_pieces(rig):
    both = encode("identify", 1) + encode("heartbeat", 2)
    rig.board.receive(both, 0)
    assert [m.name for m in rig.listen()] == ["identity", "status"]
    for byte in both[:-1]:
        rig.board.receive(bytes([byte]), 0)
    assert [m.name for m in rig.listen()] == ["identity"]
    rig.board.receive(both[-1:], 0)
    assert [m.name for m in rig.listen()] == ["status"]


def test_the_answer_in_pieces(rig):
    rig.board.receive(encode("get", 1, first=0, count=32) + encode("heartbeat", 2), 0)
    parts = []
    while part := rig.board.transmit(0, room=7):
        parts.append(part)
    assert max(map(len, parts)) == 7
    assert [m.name for m in rig.decoder.feed(b"".join(parts))] == ["words", "status"]


def test_a_frame_that_comes_twice_does_no_harm(rig):
    """Everything that a host says in a session, each frame once and each frame twice: the same amplitudes."""
    points = np.linspace(5000, 7000, 100).astype(int)
    play = {"source": 1, "loops": 1, "count": 100, "step": 1 << 22, "start_um": 0}
    session = [
        ("hello", {"major": MAJOR, "nonce": 76}),
        ("set", {"first": 0, "values": rig.words[:32]}),
        ("commit", {"crc": zlib.crc32(rig.words.astype("<f8").tobytes())}),
        ("waveform", {"first": 0, "values": points}),
        ("play", play | {"crc": zlib.crc32(points.astype("<i2").tobytes())}),
        ("mode", {"state": 1}),
        ("mode", {"state": 2}),
        ("stream", {"decimation": 1, "mask": 255}),
        ("clear", {}),
    ]
    drives, samples = [], []
    for times in (1, 2, 3):
        again = type(rig)(rig.words)
        path = []
        for sequence, (name, fields) in enumerate(session):
            for _ in range(times):  # the second a tick later, as when an answer was lost
                again.board.receive(encode(name, sequence, 77, **fields), again.now_us)
                path.append(again.tick()) if _ == 0 else None
                assert {m.name for m in again.listen()} <= {"done", "welcome"}
            path.append(again.tick(30))
        drives.append(path)
        samples.append(again.telemetry()["f_r"])
    assert drives[0] == drives[1] == drives[2]
    np.testing.assert_array_equal(samples[0], samples[1])
    assert len(set(drives[0])) > 5


def test_a_new_host_that_counts_from_where_the_last_one_did_begins_its_table_anew(rig):
    points = np.arange(100)
    play = {"source": 1, "loops": 0, "count": 100, "step": 1 << 24, "start_um": 0}
    rig.stream()
    for _ in range(2):
        rig.sequence = 10
        rig.greet()
        rig.ask("waveform", first=0, values=points)
        assert rig.reason("play", **play, crc=zlib.crc32(points.astype("<i2").tobytes())) == "done"
        rig.tick(20)
        rig.listen()
    rig.tick(8)
    np.testing.assert_allclose(rig.telemetry()["f_r"][:32], 1e-4 * np.append(np.arange(20), np.arange(12)), atol=1e-9)


@pytest.mark.parametrize("extra", [-1, 1, 3])
def test_a_body_of_the_wrong_length(rig, extra: int):
    for name in (message["name"] for message in schema()["message"] if message["to"] == "device"):
        layout = LAYOUTS[name]
        size = layout.body.size + (2 * layout.item.itemsize if layout.item else 0) + extra
        assert not layout.item or extra % layout.item.itemsize  # an odd length
        if size >= 0:
            body = bytes([MAJOR] * (name == "hello")).ljust(size, b"\0")
            rig.board.receive(framed(HEADER.pack(layout.type, 9, 0) + body), 0)
            (answer,) = rig.listen()
            told = (answer.name, answer["reason"], answer["sequence"], answer["index"])
            assert told == ("refused", 2, 9, 65535), name


def test_too_many_or_no_values(rig):
    rig.greet()
    for name, most in (("set", 32), ("waveform", 128)):
        size = LAYOUTS[name].item.itemsize
        for count, reason in ((0, "wrong_length"), (most + 1, "wrong_length"), (most, "done")):
            body = bytes(2) + bytes(size * count)
            rig.sequence += 1
            rig.board.receive(framed(HEADER.pack(LAYOUTS[name].type, rig.sequence, rig.session) + body), 0)
            (answer,) = rig.listen()
            assert answer.name == ("done" if reason == "done" else "refused")


def test_an_unknown_message_is_refused_and_an_echo_is_not_answered(rig):
    rig.board.receive(framed(HEADER.pack(200, 7, 0)), 0)
    (answer,) = rig.listen()
    assert (answer.name, answer["reason"], answer["sequence"]) == ("refused", 1, 7)
    for message in schema()["message"]:
        if message["to"] == "host":
            rig.board.receive(framed(HEADER.pack(message["type"], 8, 0) + bytes(20)), 0)
            assert rig.listen() == []


def test_what_was_counted(rig):
    for sequence in (1, 2, 5, 5, 6):  # two missing, one twice
        rig.board.receive(encode("heartbeat", sequence), 0)
    broken = bytearray(encode("heartbeat", 7))
    broken[3] ^= 0x10
    rig.board.receive(bytes(broken), 0)
    rig.board.took(3.5)
    rig.board.took(2.0)
    rig.tick(9)
    rig.listen()
    rig.sequence = 7
    told = rig.ask("statistics")
    assert told.fields == {
        "ticks": 9, "overruns": 0, "longest_us": 896, "frames": 6, "broken": 1, "missed": 3, "dropped": 0,
    }  # fmt: skip


def test_the_clock_and_the_sequence_of_the_board(rig):
    rig.now_us = 2**32 - 150
    rig.tick()
    first, second = rig.ask("heartbeat"), rig.ask("heartbeat")
    assert first.stamp == 50
    assert second.sequence == first.sequence + 1


@pytest.mark.parametrize("decimation", [1, 2, 7, 5000])
def test_telemetry_has_every_sample(rig, decimation: int):
    rig.stream(decimation)
    for _ in range(2000):
        rig.tick(16 if decimation > 7 else 1)
        rig.listen()
    rig.ask("stream", decimation=0, mask=0)
    rig.listen()
    ticks = rig.telemetry()["tick"]
    np.testing.assert_array_equal(ticks, np.arange(decimation, rig.ticks + 1, decimation))
    assert max(len(m["values"]) for m in rig.told) <= 16 * 8


def test_samples_that_nobody_took_are_counted_and_the_rest_has_its_ticks(rig):
    rig.stream()
    rig.tick(60)  # the ring has 35
    rig.listen()
    rig.tick(20)
    rig.ask("stream", decimation=0, mask=0)
    rig.listen()
    np.testing.assert_array_equal(rig.telemetry()["tick"], [*range(1, 36), *range(61, 81)])
    assert rig.told[-1]["dropped"] == 25
    assert rig.ask("statistics")["dropped"] == 25


@pytest.mark.parametrize("mask", [1, 0b10101010, 255])
def test_channels_of_the_mask_in_their_order(rig, mask: int):
    rig.mode("open")
    rig.ask("stream", decimation=1, mask=mask)
    rig.tick(16)
    rig.listen()
    frame = rig.told[-1]
    assert frame["mask"] == mask
    all_channels = [6000, 0, 6000, 0, 0, 0, 2500, 0]
    wanted = [all_channels[k] for k in range(8) if mask >> k & 1]
    row = frame["values"].reshape(16, -1)[0]
    assert len(row) == len(wanted)
    if mask & 1:
        assert row[0] == 6000


def test_telemetry_tells_what_was_measured_in_its_units(rig):
    rig.run(3000)
    rig.mode("open")
    rig.stream()
    rig.tick(16)
    rig.listen()
    told = rig.telemetry()
    k = np.arange(rig.ticks - 15, rig.ticks + 1)
    np.testing.assert_allclose(told["f_m"], (8000 + k % 3) * 5 / 2**16, rtol=0, atol=0.51e-4)
    np.testing.assert_allclose(told["position"], 4e-6 * k, rtol=0, atol=0.51e-5)
    np.testing.assert_allclose(told["speed"], 0.02, rtol=0, atol=5.1e-5)
    np.testing.assert_allclose(told["load"], 0.5, rtol=0, atol=1.1e-4)
    np.testing.assert_allclose(told["a"], rig.drive.amplitude_um, rtol=0, atol=0.51e-4)
    assert set(told["flags"]) == {1 | 1 << 2}


def test_more_frames_than_answers_fit_lose_answers_not_the_board(rig):
    rig.board.receive(b"".join(encode("heartbeat", k) for k in range(40)), 0)
    assert len(rig.listen()) == 16
    assert rig.ask("heartbeat").name == "status"
