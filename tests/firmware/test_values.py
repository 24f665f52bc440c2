"""Which values a parameter table has: one fingerprint for the same values, and the names where they differ."""

from __future__ import annotations

import re
import shutil
import zlib
from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.laws import LAWS
from frictionloop.device.codec import Decoder, encode
from frictionloop.device.emulator import TeensyEmulator
from frictionloop.device.emulator.teensy import RESETS
from frictionloop.device.errors import Refused
from frictionloop.device.simulated_boards import HostBoard
from frictionloop.firmware import build_identity
from frictionloop.firmware.image_law import board_law
from frictionloop.firmware.parameter_files import differing, fingerprint, word_of
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.firmware.system_export import export
from frictionloop.loop.registered_blocks import forget
from frictionloop.quantities.protocol_schema import firmware_folder, schema, table_hash, word_count
from tests.helpers.own_laws import register_both

BENCH = fl.bench()


def words_of(**changes):
    return firmware_words(BENCH.evolve({name.replace("__", "."): value for name, value in changes.items()}))


def test_the_same_values_have_the_same_fingerprint_and_any_other_word_another():
    words = firmware_words(BENCH)
    assert fingerprint(words) == fingerprint(firmware_words(fl.bench()))
    seen = {fingerprint(words)}
    for k in range(word_count()):
        other = words.copy()
        other[k] += 1.0
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
    near[word.first] = np.nextafter(near[word.first], 10.0)
    ((name, mine, theirs),) = differing(one, near)
    assert name == "drive.ceiling_um" and mine != theirs
    assert float(theirs.split()[0]) - float(mine.split()[0]) > 0


# What a reset came from: told by every board, and a fault where it should not have been.


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


@pytest.mark.parametrize("reset", set(AFTER) & set(RESETS))
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
    table[0] = -1.0
    board = HostBoard(table, reset=NAMES["watchdog"])
    board.receive(encode("heartbeat", 1), 0)
    status = Decoder().feed(board.transmit(0))[-1]
    assert (status["reset"], status["fault"]) == (NAMES["watchdog"], FAULTS["bad_parameter"])


# Which firmware it is: told by the image, and held against the sources here when the emulator refuses it.


@pytest.fixture
def sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a copy of the C sources that stands in their place."""
    copy = Path(shutil.copytree(firmware_folder(), tmp_path / "firmware"))
    monkeypatch.setattr(build_identity, "firmware_folder", lambda: copy)
    build_identity.revision_here.cache_clear()
    yield copy
    build_identity.revision_here.cache_clear()


def test_it_is_the_version_and_eight_digits_and_fits_its_field():
    told = build_identity.revision_here()
    assert re.fullmatch(r"[\w.+]+\+[0-9a-f]{8}", told)
    assert len(told) <= build_identity.REVISION_BYTES


def test_a_long_version_gives_way_to_the_checksum(monkeypatch, sources):
    monkeypatch.setattr(build_identity, "package_version", lambda: "10.20.30.dev4")
    assert build_identity.revision_here().startswith("10.20.3+")
    assert len(build_identity.revision_here()) == 16


def test_the_checksum_is_the_crc_of_names_and_contents(sources):
    files = sorted(
        str(path.relative_to(sources).as_posix()) for path in sources.rglob("*") if path.suffix in (".c", ".h")
    )
    joined = b"".join(name.encode() + b"\0" + (sources / name).read_bytes() + b"\0" for name in files)
    assert build_identity.revision_here().endswith(f"+{zlib.crc32(joined):08x}")


@pytest.mark.parametrize("change", ["content", "name", "line ends"])
def test_what_changes_it(sources, change):
    before = build_identity.revision_here()
    build_identity.revision_here.cache_clear()
    file = sources / "core" / "app_drive.c"
    if change == "content":
        file.write_bytes(file.read_bytes() + b"\n")
    elif change == "name":
        file.rename(file.with_name("app_drive_2.c"))
    else:
        file.write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))
    assert (build_identity.revision_here() == before) == (change == "line ends")


def test_an_image_tells_it(images):
    assert build_identity.revision_of(images("pi").elf) == build_identity.revision_here()
    assert build_identity.other_sources(images("pi").elf) == ""


def test_a_file_without_one_says_nothing(tmp_path):
    (tmp_path / "a.elf").write_bytes(b"no ELF file")
    assert build_identity.other_sources(tmp_path / "a.elf") == ""
    assert build_identity.other_sources(tmp_path / "none.elf") == ""


# An image has one law beside the lookup, says which, and refuses the table of another in one line.


def test_an_image_tells_its_law_and_refuses_the_table_of_another():
    with fl.connect("sim:") as device:
        assert (device.info.law, device.info.law_hash) == ("pi", board_law(LAWS["pi"]).hash)
        with pytest.raises(Refused) as refused:
            device.upload(BENCH.evolve({"controller.kind": "limit_observer"}))
        assert device.parameters.hold(firmware_words(BENCH))
    has, other = (board_law(LAWS[kind]).hash for kind in ("pi", "limit_observer"))
    assert str(refused.value) == (
        f"commit: refused, law.hash = {other}: must be {has} (pi) or 0 (lookup); firmware build FILE has another"
    )


def test_the_table_of_another_rate_is_refused_before_anything_is_written():
    """Its gains and its ticks are for other periods."""
    quick = BENCH.evolve({"controller.rate_hz": 10_000.0})
    with fl.connect("sim:") as device:
        for write in (device.upload, lambda each: fl.device.configure(device, system=each)):
            with pytest.raises(
                fl.FrictionloopError, match=r"^controller.rate_hz = 10000 Hz: must be 5000 on this board$"
            ):
                write(quick)
        assert device.parameters.hold(firmware_words(BENCH))
    with fl.connect("sim:", quick) as device:
        assert device.info.tick_hz == 10_000
        device.upload(quick.evolve({"controller.kp": 0.05}))


def test_open_and_closed_loop_alternate_without_another_image():
    """Every image has the lookup: by its state open, and by the table of a system whose law it is."""
    with fl.connect("sim:") as device:
        for kind in ("lookup", "pi", "lookup"):
            device.upload(BENCH.evolve({"controller.kind": kind}))
            device.mode("closed")
            assert device.controller.kind == kind
            device.mode("idle")


def test_a_law_of_ones_own_is_on_the_board_as_it_is_registered():
    """fl.register, and nothing else."""
    register_both()
    try:
        with fl.connect("sim:", BENCH.evolve({"controller.kind": "dead_band_pi"})) as device:
            assert device.info.law == "dead_band_pi"
            device.set("controller.band_n", 0.25)
            device.commit()
            assert device.parameters["law.gains"][:3].tolist() == [2.0, 400.0, 0.25]
    finally:
        forget()
