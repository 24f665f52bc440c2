"""What a reset came from: told by every board, and a fault where it should not have been."""

from __future__ import annotations

import pytest

from frictionloop.device.bench_boards import HostBoard
from frictionloop.device.codec import Decoder, encode
from frictionloop.device.emulator import TeensyEmulator
from frictionloop.device.emulator.teensy import RESETS
from frictionloop.quantities.schema import schema

NAMES = schema()["resets"]
FAULTS, STATES = schema()["faults"], schema()["states"]
AFTER = {"brown_out": "brown_out", "watchdog": "watchdog"}


def asked(board, name: str, sequence: int, session: int = 0, **fields):
    """Return what an emulated board answers, and the faults that it tells."""
    board.receive(encode(name, sequence, session, **fields))
    for _ in range(5):
        board.tick((0, 0), 0, 0)
    messages = Decoder().feed(board.transmit())
    return [m for m in messages if m.name != "fault"][-1], [m["fault"] for m in messages if m.name == "fault"]


@pytest.mark.parametrize("reset", RESETS)
def test_the_image_tells_what_its_registers_say(reset, images):
    pytest.importorskip("unicorn", reason="install frictionloop[emulator]")
    board = TeensyEmulator(images("pi").elf, reset)
    identity, told = asked(board, "identify", 1)
    status, _ = asked(board, "heartbeat", 2)
    assert identity["reset"] == status["reset"] == NAMES[reset]
    fault = AFTER.get(reset, "none")
    assert status["fault"] == FAULTS[fault]
    assert status["state"] == STATES["idle" if fault == "none" else "fault"]
    assert told == ([] if fault == "none" else [FAULTS[fault]])


@pytest.mark.parametrize("reset", AFTER)
def test_the_loop_stays_off_until_the_fault_is_cleared(reset, images):
    pytest.importorskip("unicorn", reason="install frictionloop[emulator]")
    board = TeensyEmulator(images("pi").elf, reset)
    welcome, _ = asked(board, "hello", 1, major=schema()["protocol"]["major"], nonce=5)
    session, closed = welcome["session"], {"state": STATES["closed"]}
    refused, _ = asked(board, "mode", 2, session, **closed)
    assert (refused.name, refused["reason"]) == ("refused", schema()["refusals"]["not_now"])
    assert board.duty == 0
    assert asked(board, "clear", 3, session)[0].name == "done"
    assert asked(board, "mode", 4, session, **closed)[0].name == "done"
    assert asked(board, "heartbeat", 5, session)[0]["state"] == STATES["closed"]


@pytest.mark.parametrize("reset", [name for name in NAMES if name not in AFTER])
def test_any_other_reset_is_none(reset, words):
    board = HostBoard(words, reset=NAMES[reset])
    board.receive(encode("heartbeat", 1), 0)
    (status,) = Decoder().feed(board.transmit(0))
    assert (status["reset"], status["state"]) == (NAMES[reset], STATES["idle"])


def test_a_bad_table_goes_before(words):
    table = words.copy()
    table[0] = 15
    board = HostBoard(table, reset=NAMES["watchdog"])
    board.receive(encode("heartbeat", 1), 0)
    status = Decoder().feed(board.transmit(0))[-1]
    assert (status["reset"], status["fault"]) == (NAMES["watchdog"], FAULTS["bad_parameter"])
