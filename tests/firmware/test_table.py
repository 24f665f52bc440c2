"""The parameter table: written in pieces, checked word by word and as a whole, in force at a tick."""

from __future__ import annotations

import zlib

import numpy as np
import pytest

from frictionloop.quantities.protocol_schema import parameter_words, word_count

AT = {name: word.first for name, word in parameter_words().items()}


def write(rig, words: np.ndarray) -> None:
    for first in range(0, len(words), 32):
        answer = rig.ask("set", first=first, values=words[first : first + 32])
        assert answer.name == "done"


def crc(words: np.ndarray) -> int:
    return zlib.crc32(words.astype("<f8").tobytes())


def read(rig) -> np.ndarray:
    parts = []
    for first in range(0, word_count(), 32):
        answer = rig.ask("get", first=first, count=min(32, word_count() - first))
        assert (answer.name, answer["first"]) == ("words", first)
        parts.append(answer["values"])
    return np.concatenate(parts)


def test_words_are_in_force_from_the_next_tick_on(rig, words):
    np.testing.assert_array_equal(read(rig), words)
    changed = words.copy()
    changed[AT["setpoint.hold_n"]] = 0.4
    write(rig, changed)
    rig.tick()
    np.testing.assert_array_equal(read(rig), words)
    assert rig.reason("commit", crc=crc(changed)) == "done"
    np.testing.assert_array_equal(read(rig), words)
    rig.tick()
    np.testing.assert_array_equal(read(rig), changed)


def test_one_word_after_the_other_without_writing_the_rest(rig, words):
    changed = words.copy()
    for level in (0.3, 0.5, 0.7):
        changed[AT["setpoint.hold_n"]] = level
        rig.ask("set", first=AT["setpoint.hold_n"], values=changed[AT["setpoint.hold_n"] :][:1])
        assert rig.reason("commit", crc=crc(changed)) == "done"
        rig.tick()
        np.testing.assert_array_equal(read(rig), changed)


def test_between_commit_and_tick_nothing_is_written_and_the_same_commit_is_done(rig, words):
    assert rig.reason("commit", crc=crc(words)) == "done"
    assert rig.reason("commit", crc=crc(words)) == "done"
    assert rig.reason("set", first=0, values=words[:1]) == "not_now"
    rig.tick()
    assert rig.reason("set", first=0, values=words[:1]) == "done"


def test_a_wrong_crc_changes_nothing(rig, words):
    changed = words.copy()
    changed[AT["setpoint.hold_n"]] += 1
    write(rig, changed)
    assert rig.reason("commit", crc=crc(words)) == "wrong_crc"
    rig.tick()
    np.testing.assert_array_equal(read(rig), words)


def limits() -> list[tuple[int, float]]:
    """Return (index, value) of what a parameter's last number may not be: outside its range, none, or no whole one."""
    found = []
    for word in parameter_words().values():
        step = 1.0 if word.format == "count" else 1e-6 * max(abs(word.low), abs(word.high))
        values = [word.low - step, word.high + step, np.nan, np.inf] + [word.low + 0.5] * (word.format == "count")
        found += [(word.first + word.count - 1, value) for value in values]
    return found


def test_a_word_out_of_range_is_refused_by_its_index_and_none_of_the_frame_is_written(rig, words):
    for index, value in limits():
        first = max(index - 3, 0)
        values = words[first : index + 1].copy()
        values[0] = 4.0 if first == 0 else values[0]
        values[-1] = value
        answer = rig.ask("set", first=first, values=values)
        assert (answer.name, answer["reason"], answer["index"]) == ("refused", 5, index)
        assert rig.reason("commit", crc=crc(words)) == "done"  # what waits is still the table in force
        rig.tick()
    assert len(limits()) > 150


def test_the_ends_of_a_range_are_accepted(rig):
    for name, word in parameter_words().items():
        for end in (word.low, word.high):
            assert rig.reason("set", first=word.first + word.count - 1, values=[end]) == "done", name


WHOLE = {
    "law of another image": ({"law.hash": [15]}, AT["law.hash"]),
    "clamp empty": ({"law.low_n": [1.0]}, AT["law.high_n"]),
    "table of one": ({"lookup.entries": [1]}, AT["lookup.entries"]),
    "ceiling above the largest": ({"drive.ceiling_um": [3.0]}, AT["drive.ceiling_um"]),
    "no largest": ({"drive.largest_um": [0], "drive.ceiling_um": [0]}, AT["drive.largest_um"]),
    "down in a tick more than 0.1 s": ({"drive.ramp_um": [2.5 / 501]}, AT["drive.ramp_um"]),
    "down in 40 000 s": ({"drive.ramp_um": [1.1e-8]}, AT["drive.ramp_um"]),
    "lookup rises": ({"lookup.entries": [2], "lookup.squares_um2": [1.0, 1.1]}, AT["lookup.squares_um2"] + 1),
    "longer than half a period of the mains": ({"safety.hum_ticks": [51]}, AT["safety.hum_ticks"]),
}  # fmt: skip


@pytest.mark.parametrize("case", WHOLE)
def test_a_table_that_makes_no_sense_is_refused_by_the_index_of_what_is_wrong(rig, words, case):
    changed, index = words.copy(), WHOLE[case][1]
    for name, values in WHOLE[case][0].items():
        changed[AT[name] : AT[name] + len(values)] = values
    write(rig, changed)
    answer = rig.ask("commit", crc=crc(changed))
    assert (answer.name, answer["reason"], answer["index"]) == ("refused", 5, index)
    rig.tick()
    np.testing.assert_array_equal(read(rig), words)


@pytest.mark.parametrize(
    ("largest_um", "ceiling_um", "answer"),
    [
        (2.5, 1.0, "done"),
        (2.5, 1.001, "out_of_range"),
        (5.0, 2.0, "done"),  # of a plate that moves twice as far, the same duty
        (1.0, 1.0, "out_of_range"),  # half duty called 1 um
        (0.02, 0.02, "out_of_range"),
    ],
)
def test_no_table_takes_a_larger_duty_than_the_image_was_built_with(make_rig, largest_um, ceiling_um, answer):
    rig = make_rig(drive__ceiling_um=1.0)
    changed = rig.words.copy()
    changed[[AT["drive.largest_um"], AT["drive.ceiling_um"]]] = largest_um, ceiling_um
    write(rig, changed)
    assert rig.reason("commit", crc=crc(changed)) == answer


@pytest.mark.parametrize(("name", "longest"), [("safety.force_ticks", 1000), ("safety.overrun_ticks", 50)])
def test_no_table_makes_a_fault_wait_longer_than_the_image_lets_it(rig, name, longest):
    assert rig.reason("set", first=AT[name], values=[longest]) == "done"
    assert rig.reason("set", first=AT[name], values=[longest + 1]) == "out_of_range"


def test_words_beyond_the_table(rig):
    for name, fields in (("set", {"values": [0, 0]}), ("get", {"count": 2})):
        answer = rig.ask(name, first=word_count() - 1, **fields)
        assert (answer["reason"], answer["index"]) == (4, word_count())
        answer = rig.ask(name, first=60_000, **fields)
        assert (answer["reason"], answer["index"]) == (4, 60_000)
    assert rig.reason("get", first=0, count=0) == "out_of_range"
    assert rig.reason("get", first=0, count=33) == "out_of_range"
