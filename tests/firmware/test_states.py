"""The table of docs/firmware-states.md, cell by cell: every event in every state."""

from __future__ import annotations

import math
import re
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest

from frictionloop.device.simulated_boards import Sample
from frictionloop.quantities.protocol_schema import parameter_words, schema

PAGE = Path(__file__).resolve().parents[2] / "docs" / "firmware-states.md"
END = 32767


def table() -> list[tuple[str, str, str]]:
    """Return (event, state, what follows) of every cell of the page's table of events."""
    text = PAGE.read_text(encoding="utf-8")
    lines = text[text.index("| event |") :].partition("\n\n")[0].splitlines()
    rows = [[cell.strip().strip("`") for cell in line.strip("|\n ").split("|")] for line in lines]
    head, _, *body = rows
    assert head[1:] == list(schema()["states"])
    cells = [(row[0].split("`, `"), *each) for row in body for each in zip(head[1:], row[1:], strict=True)]
    return [(event, state, cell) for events, state, cell in cells for event in events]


def commit(rig) -> str:
    table = rig.words.astype("<f8").tobytes()
    for first in range(0, len(rig.words), 32):
        rig.ask("set", first=first, values=rig.words[first : first + 32])
    return rig.reason("commit", crc=zlib.crc32(table))


def commit_bad(rig) -> str:
    rig.words[0] = 15  # the hash of no law here
    return commit(rig)


def silence(rig) -> str:
    rig.tick(1001)
    return "done"


def ticks(count: int, sample: Callable[[int], Sample]) -> Callable[..., str]:
    def event(rig) -> str:
        for _ in range(count):
            rig.tick(1, sample(rig.ticks))
        return "done"

    return event


def moving(force: int) -> Callable[[int], Sample]:
    return lambda k: Sample(force + k % 3, 0, 4 * k, 3277)


def humming(rig) -> str:
    rig.run(3000)  # 12 mm since it landed
    rig.ask("heartbeat")
    return ticks(700, lambda k: Sample(round(8000 + 4000 * math.sin(k * math.pi / 50)), 0, 4 * k, 3277))(rig)


def late(rig) -> str:
    rig.tick(5, late=True)
    return "done"


def lifted(rig) -> str:
    for _ in range(600):
        rig.ask("heartbeat")
        for _ in range(500):
            rig.tick(1, Sample(rig.ticks % 3, 0, 0, 0))
    return "done"


def ask(name: str, **fields: int) -> Callable[..., str]:
    return lambda rig: rig.reason(name, **fields)


EVENTS: dict[str, Callable[..., str]] = {
    **{f"mode {state}": ask("mode", state=number) for state, number in schema()["states"].items()},
    "clear": ask("clear"),
    "commit": commit,
    "commit, bad": commit_bad,
    "force_range": ticks(25, moving(32000)),
    "sensor_saturated": ticks(25, lambda k: Sample(END, 0, 4 * k, 3277)),
    "sensor_saturated, position": ticks(25, lambda k: Sample(8000 + k % 3, 0, -END - 1, 3277)),
    "sensor_saturated, load": ticks(25, lambda k: Sample(8000 + k % 3, 0, 4 * k, END)),
    "sensor_stuck": ticks(72, lambda k: Sample(8000 + k % 2, 0, 4 * k, 3277)),
    "sensor_jumps": ticks(1, lambda k: Sample(8000, 0, 4 * k + 60_000, 3277)),
    "sensor_contrary": ticks(75, lambda k: Sample(8000 + k % 3, 0, 4 * k, 0)),
    "sensor_hums": humming,
    "host_silent": silence,
    "tick_overrun": late,
    "no_finger": lifted,
}
JUMPS = ("force_jump_n", "position_jump_m", "load_jump_n")
"""A converter that is at its end has jumped there: these words keep that out of what is another event."""
FAULTS = {event: event.partition(",")[0] for event in EVENTS if event.partition(",")[0] in schema()["faults"]}


def bring(rig, state: str) -> None:
    """Bring a board into a state with a finger that has slid for a while."""
    rig.run(300)
    if state in ("open", "closed"):
        assert rig.mode(state) == "done"
    if state == "fault":
        rig.mode("open")
        silence(rig)
    assert rig.state == state


@pytest.mark.parametrize(("event", "state", "follows"), table())
def test_every_cell(make_rig, event: str, state: str, follows: str):
    # A host that is quiet only where silence is the event: other events last longer than its patience.
    jumps = {} if event == "sensor_jumps" else {f"safety__{name}": 8.0 for name in JUMPS}
    rig = make_rig(**jumps)
    bring(rig, state)
    was = rig.fault
    answer = EVENTS[event](rig)
    rig.tick()
    name, refusal = re.fullmatch(r"(\w+)(?:, refused `?(\w+)`?)?", follows).groups()
    assert (rig.state, answer) == (name, refusal or "done")
    raised = FAULTS.get(event, "none") if state in ("open", "closed") else was if state == name == "fault" else "none"
    assert rig.fault == raised


def test_the_table_has_every_event():
    assert {event for event, _, _ in table()} == set(EVENTS)


def test_a_board_that_starts_with_a_bad_table_is_at_fault_until_a_good_one_is_committed(make_rig, words):
    rig = make_rig(safety__force_ticks=0)
    rig.tick()
    assert (rig.state, rig.fault) == ("fault", "bad_parameter")
    assert rig.told[0]["value"] == parameter_words()["safety.force_ticks"].first
    assert rig.reason("clear") == "still_at_fault"
    rig.words = words
    assert commit(rig) == "done"
    rig.tick()
    assert rig.state == "fault"
    assert rig.reason("clear") == "done"
    rig.tick()
    assert rig.state == "idle"
    assert rig.mode("closed") == "done"
    assert rig.state == "closed"


def test_clear_and_a_mode_may_come_between_two_ticks(rig):
    bring(rig, "fault")
    assert rig.reason("clear") == "done"
    assert rig.mode("open") == "done"
    assert rig.state == "open"
