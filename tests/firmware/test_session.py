"""Whose loop it is: sessions, what counts as a sign of life, and frames that come late or again."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
import pytest

from frictionloop.device.codec import HEADER, LAYOUTS, Message, encode, framed
from frictionloop.quantities.protocol_schema import schema

STATES, REFUSALS = schema()["states"], schema()["refusals"]
MAJOR = schema()["protocol"]["major"]
COMMANDS: dict[str, dict[str, Any]] = {
    "set": {"first": 0, "values": [1]},
    "commit": {"crc": 0},
    "waveform": {"first": 0, "values": [1]},
    "play": {"source": 0, "loops": 0, "count": 0, "step": 0, "start_um": 0, "crc": 0},
    "mode": {"state": 2},
    "clear": {},
}


def say(rig: Any, name: str, sequence: int, session: int, **fields: Any) -> Message:
    """Send one frame as it is and return the one answer."""
    rig.board.receive(encode(name, sequence, session, **fields), rig.now_us)
    (answer,) = rig.listen()
    return answer


def hello(rig: Any, nonce: int, sequence: int = 0) -> int:
    return say(rig, "hello", sequence, 0, major=MAJOR, nonce=nonce)["session"]


def closed(rig: Any) -> int:
    """Close the loop on a finger and return the session that did."""
    rig.run(300)
    assert rig.mode("closed") == "done"
    rig.tick()
    assert rig.state == "closed"
    return rig.session


def silent_from_now(rig: Any, say_something: Any) -> list[str]:
    """Return the faults of 300 ms in which this is said every 20 ms."""
    for _ in range(15):
        rig.tick(100)
        say_something()
        rig.listen()
    return [name for m in rig.told if m.name == "fault" for name, n in schema()["faults"].items() if n == m["fault"]]


def test_a_command_without_a_session_is_refused(rig):
    for session in (0, 12345):
        for name, fields in COMMANDS.items():
            answer = say(rig, name, 1, session, **fields)
            assert (answer.name, answer["reason"]) == ("refused", REFUSALS["no_session"])


def test_who_is_there_is_answered_in_a_session_that_has_ended_too(rig):
    assert say(rig, "identify", 1, 12345).name == "identity"
    assert say(rig, "heartbeat", 2, 12345)["reason"] == REFUSALS["no_session"]


def test_a_host_of_another_version_is_told_so(rig):
    answer = say(rig, "hello", 3, 0, major=MAJOR - 1, nonce=5)
    assert (answer.name, answer["reason"], answer["sequence"]) == ("refused", REFUSALS["wrong_version"], 3)


@pytest.mark.parametrize("size", [1, 4, 6, 20])
def test_it_is_told_so_however_long_its_hello_is(rig, size: int):
    body = bytes([MAJOR + 1]).ljust(size, b"\1")
    rig.board.receive(framed(HEADER.pack(LAYOUTS["hello"].type, 3, 0) + body), rig.now_us)
    (answer,) = rig.listen()
    assert (answer.name, answer["reason"], answer["sequence"]) == ("refused", REFUSALS["wrong_version"], 3)


@pytest.mark.parametrize("name", COMMANDS)
def test_commands_of_others_are_refused_while_the_loop_is_on(rig, name: str):
    owner = closed(rig)
    other = hello(rig, 5)
    assert other != owner
    answer = say(rig, name, 1, other, **COMMANDS[name])
    assert (answer.name, answer["reason"]) == ("refused", REFUSALS["not_owner"])
    rig.tick()
    assert rig.state == "closed"
    assert rig.mode("idle") == "done"
    assert say(rig, "clear", 2, other).name == "done"  # the loop is off: its turn


def test_a_mode_that_no_tick_has_taken_yet_has_an_owner(rig):
    rig.run(300)
    assert rig.reason("mode", state=STATES["closed"]) == "done"
    answer = say(rig, "mode", 1, hello(rig, 5), state=STATES["open"])
    assert answer["reason"] == REFUSALS["not_owner"]


@pytest.mark.parametrize("taken", [True, False])
def test_anyone_may_stop_the_loop(rig, taken):
    """Also before a tick has taken the request that closes it; who stops it does not own it."""
    if taken:
        closed(rig)
    else:
        rig.run(300)
        assert rig.reason("mode", state=STATES["closed"]) == "done"
    other = hello(rig, 5)
    assert say(rig, "mode", 1, other, state=STATES["idle"]).name == "done"
    for _ in range(500):  # 0.1 s, the longest ramp
        drive = rig.tick()
    assert rig.state == "idle"
    assert drive.duty == 0


def test_a_stop_that_comes_late_or_from_no_session_stops_nothing(rig):
    closed(rig)
    other = hello(rig, 5)
    assert say(rig, "heartbeat", 5, other).name == "status"
    assert say(rig, "mode", 4, other, state=STATES["idle"])["reason"] == REFUSALS["late"]
    assert say(rig, "mode", 6, 12345, state=STATES["idle"])["reason"] == REFUSALS["no_session"]
    rig.tick()
    assert rig.state == "closed"


def test_what_another_host_asks_is_no_sign_of_life_of_the_owner(rig):
    """Nor is a stop that is refused."""
    closed(rig)
    other = hello(rig, 5)
    for sequence in range(1, 22):
        rig.tick(50)
        say(rig, "mode", sequence, other, state=STATES["open"])
    assert rig.state == "fault" and rig.fault == "host_silent"


def test_another_host_may_look_and_may_not_take_the_telemetry(rig):
    closed(rig)
    other = hello(rig, 5)
    assert say(rig, "heartbeat", 1, other).name == "status"
    assert say(rig, "get", 2, other, first=0, count=1).name == "words"
    assert say(rig, "stream", 3, other, decimation=10, mask=1).name == "done"
    rig.stream()
    answer = say(rig, "stream", 4, other, decimation=0, mask=0)
    assert answer["reason"] == REFUSALS["not_owner"]


def test_hello_while_the_loop_is_off_ends_the_session_before(rig):
    first = hello(rig, 5)
    hello(rig, 6)
    assert say(rig, "clear", 1, first)["reason"] == REFUSALS["no_session"]


def test_the_owner_stays_however_many_others_say_hello(rig):
    closed(rig)
    others = [hello(rig, nonce) for nonce in range(100, 110)]
    assert rig.mode("open") == "done"
    assert [say(rig, "clear", 1, other)["reason"] for other in others[:-1]] == [REFUSALS["no_session"]] * 9


def test_each_hello_gives_another_session_but_the_same_one_again(rig):
    rig.board.receive(encode("hello", 4, major=MAJOR, nonce=9) * 3, rig.now_us)
    assert len({answer["session"] for answer in rig.listen()}) == 1
    hello(rig, 10)
    assert hello(rig, 9) not in (10, 11)  # what was said in its first session counts no more


def test_only_the_owner_keeps_the_loop_on(rig):
    owner = closed(rig)
    other, sequence = hello(rig, 5), iter(range(1, 100))
    assert silent_from_now(rig, lambda: say(rig, "heartbeat", next(sequence), other)) == ["host_silent"]
    rig.ask("clear")
    rig.tick()
    rig.told.clear()
    assert closed(rig) == owner
    assert silent_from_now(rig, lambda: rig.ask("heartbeat")) == []


NOISE = {
    "a listener": lambda rig, k: encode("heartbeat", k),
    "a listener's wishes": lambda rig, k: encode("stream", k, decimation=1, mask=1),
    "an unknown message": lambda rig, k: framed(HEADER.pack(200, (rig.sequence + 1 + k) % 2**16, rig.session)),
    "a wrong length": lambda rig, k: framed(HEADER.pack(12, (rig.sequence + 1 + k) % 2**16, rig.session) + b"1"),
    "a refused command": lambda rig, k: encode("mode", rig.sequence + 1 + k, rig.session, state=9),
    "a refused reading": lambda rig, k: encode("get", rig.sequence + 1 + k, rig.session, first=9999, count=1),
    "the same heartbeat": lambda rig, k: encode("heartbeat", rig.sequence, rig.session),
    "an old heartbeat": lambda rig, k: encode("heartbeat", rig.sequence - 9, rig.session),
    "a hello": lambda rig, k: encode("hello", k, major=MAJOR, nonce=k),
}


@pytest.mark.parametrize("kind", NOISE)
def test_what_is_no_sign_of_life(rig, kind: str):
    closed(rig)
    rig.sequence += 20
    rig.ask("heartbeat")
    frames = iter(range(100))
    said = silent_from_now(rig, lambda: rig.board.receive(NOISE[kind](rig, next(frames)), rig.now_us))
    assert said == ["host_silent"]


def test_a_mode_that_comes_late_closes_nothing(rig):
    session = closed(rig)
    old = encode("mode", rig.sequence, session, state=STATES["closed"])
    rig.sequence += 1
    assert rig.mode("idle") == "done"
    for _ in range(3):
        rig.board.receive(old, rig.now_us)
        (answer,) = rig.listen()
        assert (answer.name, answer["reason"]) == ("refused", REFUSALS["late"])
        rig.tick(10)
        assert rig.state == "idle"
    hello(rig, 7)  # and of an earlier host
    rig.board.receive(old, rig.now_us)
    assert rig.listen()[0]["reason"] == REFUSALS["no_session"]


def test_a_mode_that_comes_again_after_a_fault_closes_nothing(rig):
    closed(rig)
    assert rig.mode("closed") == "done"
    again = encode("mode", rig.sequence, rig.session, state=STATES["closed"])
    rig.tick(1100)
    assert rig.drive.amplitude_um == 0.0
    other = hello(rig, 7)
    assert say(rig, "clear", 1, other).name == "done"
    rig.tick()
    rig.board.receive(again, rig.now_us)
    rig.listen()
    rig.tick(10)
    assert say(rig, "heartbeat", 2, other)["state"] == STATES["idle"]


def test_a_frame_that_comes_three_times_is_done_once_and_answered_three_times(rig):
    session = hello(rig, 5)
    points = np.arange(100, dtype="<i2")
    play = {"source": 1, "loops": 0, "count": 100, "step": 1 << 24, "start_um": 0}
    frames = [
        encode("stream", 1, session, decimation=1, mask=255),
        encode("waveform", 2, session, first=0, values=points),
    ]
    frames.append(encode("play", 3, session, **play, crc=zlib.crc32(points.tobytes())))
    frames.append(encode("commit", 4, session, crc=zlib.crc32(rig.words.astype("<f8").tobytes())))
    for frame in frames:
        for _ in range(3):
            rig.board.receive(frame, rig.now_us)
            assert [m.name for m in rig.listen()] == ["done"]
            rig.tick(3)
    rig.tick(16)
    played = np.rint(rig.telemetry()["f_r"] * 1e4)
    assert played[played < 1000].tolist() == list(range(np.sum(played < 1000)))  # begun once
    assert np.sum(played < 1000) > 20
    assert rig.ask("heartbeat")["commits"] == 1


def test_a_refusal_comes_again_as_it_was(rig):
    session = hello(rig, 5)
    for _ in range(2):
        answer = say(rig, "set", 1, session, first=0, values=[-1.0])
        assert (answer["reason"], answer["index"]) == (REFUSALS["out_of_range"], 0)


def test_the_counter_goes_on_past_its_end(rig):
    session = hello(rig, 5, sequence=65534)
    for sequence in (65535, 0, 1):
        assert say(rig, "clear", sequence, session).name == "done"
    assert say(rig, "clear", 65535, session)["reason"] == REFUSALS["late"]


def test_every_status_tells_how_many_tables_were_put_in_force(rig):
    assert rig.ask("heartbeat")["commits"] == 0
    for count in (1, 2):
        assert rig.reason("commit", crc=zlib.crc32(rig.words.astype("<f8").tobytes())) == "done"
        rig.tick()
        assert rig.ask("heartbeat")["commits"] == count
