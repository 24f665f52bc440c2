"""Which values a parameter table has: one fingerprint for the same values, and the names where they differ."""

import zlib

import frictionloop as fl
from frictionloop.firmware.exported import export
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.firmware.words import differing, fingerprint, word_of
from frictionloop.quantities.schema import table_hash, word_count

BENCH = fl.bench()


def words_of(**changes):
    return firmware_words(BENCH.evolve({name.replace("__", "."): value for name, value in changes.items()}))


def test_the_same_values_have_the_same_fingerprint_and_any_other_word_another():
    words = firmware_words(BENCH)
    assert fingerprint(words) == fingerprint(firmware_words(fl.bench()))
    seen = {fingerprint(words)}
    for k in range(word_count()):
        other = words.copy()
        other[k] ^= 1
        seen.add(fingerprint(other))
    assert len(seen) == 1 + word_count()


def test_the_fingerprint_is_that_of_the_file_of_words_and_not_that_of_the_layout(tmp_path):
    table = export(BENCH.evolve({"controller.kp": 0.05}), tmp_path)
    of_file = f"{zlib.crc32((tmp_path / 'parameters.bin').read_bytes()):08x}"
    assert table.values == of_file
    assert (tmp_path / "values.txt").read_text() == f"values {of_file}\n"
    assert table.layout == f"{table_hash():08x}" != of_file
    assert export(BENCH, tmp_path).layout == table.layout


def test_the_written_system_gives_the_same_values(tmp_path):
    changed = BENCH.evolve({"controller.kp": 0.0621, "plate.q": 311.0, "board.ceiling_um": 0.7})
    export(changed, tmp_path)
    assert fingerprint(firmware_words(fl.read_toml(tmp_path / "system.toml"))) == fingerprint(firmware_words(changed))


def test_where_two_tables_differ_is_named_with_both_values():
    one, other = words_of(controller__kp=0.05), words_of(controller__kp=0.062, board__ceiling_um=0.5)
    assert differing(one, one) == []
    assert {name: (mine, theirs) for name, mine, theirs in differing(one, other)} == {
        "law.gains[0]": ("0.05", "0.062"),
        "drive.ceiling_um": ("2.5 um", "0.5 um"),
    }


def test_values_that_six_digits_do_not_tell_apart_get_more():
    one, word = firmware_words(BENCH), word_of("drive.ceiling_um")
    near = one.copy()
    near[word.first] += 1
    ((name, mine, theirs),) = differing(one, near)
    assert name == "drive.ceiling_um" and mine != theirs
    assert float(theirs.split()[0]) - float(mine.split()[0]) > 0


def test_words_that_stand_for_the_same_number_are_shown_as_words():
    one, first = firmware_words(BENCH), word_of("law.gains").first
    one[first] -= one[first] % 2
    same = one.copy()
    same[first], same[first + 1] = one[first] // 2, one[first + 1] - 1
    ((name, mine, theirs),) = differing(one, same)
    assert (name, mine) == ("law.gains[0]", f"words {one[first]} {one[first + 1]}")
    assert theirs == f"words {one[first] // 2} {one[first + 1] - 1}"
