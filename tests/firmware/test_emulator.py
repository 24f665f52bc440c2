"""The flashable image in the emulated Teensy."""

import numpy as np
import pytest
from broken_sensors import FAILURES, bench

from frictionloop import FrictionloopError
from frictionloop.device.bench_boards import HostBoard, Sample
from frictionloop.device.codec import Decoder, encode
from frictionloop.device.emulator import TeensyEmulator
from frictionloop.device.emulator.budget import SESSION, edges, heartbeat, hello, opening, strokes
from frictionloop.device.emulator.registers import Bank
from frictionloop.firmware.image import build
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.quantities.schema import named, schema

pytest.importorskip("unicorn", reason="install frictionloop[emulator]")

PERIOD = 783


@pytest.fixture
def board(images):
    return TeensyEmulator(images("pi").elf)


def fields(message):
    return message.name, {name: np.asarray(value).tolist() for name, value in message.fields.items()}


def test_clocks_tick_carrier_and_port_are_those_of_the_design(board):
    assert board.frequencies() == (72e6, 36e6, 24e6)
    assert board._bank.values["PIT_LDVAL0"] + 1 == 36e6 / 5000
    assert board.period == 783
    assert board.baud() == 2e6


def test_the_carrier_is_off_until_a_host_closes_the_loop(board):
    assert [board.tick((9000, 0), 3277, 4 * k) for k in range(50)] == [0.0] * 50


def test_the_identity_is_told(board):
    board.receive(encode("identify", 7))
    board.tick((0, 0), 0, 0)
    board.tick((0, 0), 0, 0)
    (identity,) = Decoder().feed(board.transmit())
    assert identity.name == "identity"
    assert identity["board"] == schema()["boards"]["teensy31"]
    assert identity["tick_hz"] == 5000


@pytest.mark.parametrize(
    ("law", "period"), [*((law, PERIOD) for law in ("pi", "notch_pi", "limit_observer")), ("pi", 942)]
)
def test_every_duty_is_the_host_librarys(law, period, images, law_words, tmp_path):
    """The same bits in the processor's carrier as in this machine's library, compare value by compare value."""
    words = law_words[law]
    ours = (
        build("teensy31", words.tolist(), tmp_path, laws=[law], carrier_ticks=period)
        if period != PERIOD
        else images(law)
    )
    teensy, host = TeensyEmulator(ours.elf), HostBoard(words)
    pending = [opening()[k : k + 40] for k in range(0, len(opening()), 40)]
    teensy.receive(opening())
    told, heard = Decoder(), Decoder()
    seen, expected, closed = [], [], 0
    for k, (force, load, position) in enumerate([*strokes(600, seed=3), *edges(100, seed=4)]):
        duty = teensy.tick(force, load, position)
        drive = host.tick(Sample(*force, position, load), 200 * k)
        compare = (2 * drive.duty * period + 2**17 - 1) // 2**18  # nearest, halves down
        assert teensy.compare == compare
        assert duty == compare / period and (not closed or teensy.period == period)
        closed += compare > 0
        if pending:
            host.receive(pending.pop(0), 200 * k + 300)
        seen += told.feed(teensy.transmit())
        expected += heard.feed(host.transmit(200 * k + 300))
    assert closed > 300
    telemetry = [fields(message) for message in seen if message.name == "telemetry"]
    assert len(telemetry) > 30
    assert telemetry == [fields(message) for message in expected if message.name == "telemetry"][: len(telemetry)]


def test_bytes_beyond_what_the_wire_takes_wait(board):
    """2 Mbaud, ten bits a byte: 40 bytes a tick."""
    frames = b"".join(heartbeat(k, 0) for k in range(40))
    board.receive(frames)
    ticks = -(-len(frames) // 40)
    decoder, answers = Decoder(), []
    for _ in range(ticks):
        board.tick((0, 0), 0, 0)
        sent = board.transmit()
        assert len(sent) <= 40
        answers += decoder.feed(sent)
    for _ in range(30):
        board.tick((0, 0), 0, 0)
        answers += decoder.feed(board.transmit())
    assert 0 < len(answers) <= 40
    assert {answer.name for answer in answers} == {"status"}


def test_late_ticks_are_counted_and_raise_the_fault(board):
    for late_us, expected in ((9.0, 0), (11.0, 3)):
        board.late_us = late_us
        for _ in range(3):
            board.tick((0, 0), 0, 0)
        board.late_us = 0.0
        board.receive(encode("statistics", 1))
        for _ in range(4):
            board.tick((0, 0), 0, 0)
        (counted,) = Decoder().feed(board.transmit())
        assert counted["overruns"] == expected


def closed(board):
    board.receive(opening())
    for force, load, position in strokes(200):
        board.tick(force, load, position)
    assert board.duty > 0


def test_a_hard_fault_switches_the_carrier_off(board):
    closed(board)
    handler = board.processor.vector(16 + 68) & ~1
    board.processor.uc.mem_write(handler, b"\x00\xde")  # UDF, an instruction that is none
    board.processor.uc.ctl_flush_tb()
    with pytest.raises(FrictionloopError, match=f"faults at 0x{handler:08x}"):
        board.tick((0, 0), 0, 0)
    assert board.duty == 0
    with pytest.raises(FrictionloopError, match="faults at"):
        board.tick((0, 0), 0, 0)


def test_an_unknown_register_ends_the_run(board):
    closed(board)
    handler = board.processor.vector(16 + 68) & ~1
    # movw r0, #0xB100; movt r0, #0x4003; ldr r0, [r0]
    code = bytes.fromhex("4bf20010 c4f20300 0068".replace(" ", ""))
    board.processor.uc.mem_write(handler, code)
    board.processor.uc.ctl_flush_tb()
    with pytest.raises(FrictionloopError, match="reads 0x4003b100, 4 bytes: no register"):
        board.tick((0, 0), 0, 0)


def test_a_block_without_its_clock_is_out_of_reach():
    bank = Bank()
    with pytest.raises(FrictionloopError, match=r"reads PIT_CVAL0: clock off, SIM_SCGC6 bit 23"):
        bank.read(0x40037104, 4)
    bank.write(0x4004803C, 4, 1 << 23)
    assert bank.read(0x40037104, 4) == 0
    bank.write(0x4004803C, 4, 0)
    with pytest.raises(FrictionloopError, match="writes PIT_MCR: clock off"):
        bank.write(0x40037000, 4, 0)


@pytest.mark.parametrize("modulus", [100, 7200])
def test_a_delay_block_that_misses_the_tick_is_refused(board, modulus):
    """Too short to start the converters, or still running when the next trigger comes."""
    board._bank.values["PDB_MOD"] = modulus
    with pytest.raises(FrictionloopError, match="PDB_MOD: ADC0 not done in a tick"):
        board.tick((0, 0), 0, 0)


def test_the_watchdog_counts_with_its_prescaler(board):
    board._bank.values["WDOG_PRESC"] = 4 << 8
    assert board._watchdog.timeout_s() == pytest.approx(0.25)


def test_an_image_that_leaves_the_watchdog_alone_is_refused(images, tmp_path):
    content = images("pi").elf.read_bytes()
    for word in (0xC520, 0xD928):
        assert movw(word) in content
    spoilt = tmp_path / "spoilt.elf"
    spoilt.write_bytes(content.replace(movw(0xC520), movw(0xC521)))
    with pytest.raises(FrictionloopError, match="watchdog not unlocked first"):
        TeensyEmulator(spoilt)


def movw(value):
    """The first three bytes of MOVW Rd, #value but for Rd: ARMv7-M A7.7.76, encoding T3."""
    imm4, i, imm3, imm8 = value >> 12, value >> 11 & 1, value >> 8 & 7, value & 255
    first, second = 0xF240 | i << 10 | imm4, imm3 << 12 | imm8
    return first.to_bytes(2, "little") + bytes([second & 255])


def test_a_file_that_is_no_image_is_named(tmp_path):
    text = tmp_path / "notes.txt"
    text.write_text("not an image")
    with pytest.raises(FrictionloopError, match=r"notes\.txt: no ELF file"):
        TeensyEmulator(text)
    with pytest.raises(FrictionloopError, match=r"missing\.elf: cannot be read"):
        TeensyEmulator(tmp_path / "missing.elf")


def test_an_image_that_is_no_teensys_is_one_line(images, tmp_path):
    content = bytearray(images("pi").elf.read_bytes())
    content[content.index(bytes.fromhex("def9ffff"))] = 0
    (tmp_path / "other.elf").write_bytes(content)
    with pytest.raises(FrictionloopError, match=r"other\.elf: is no Teensy image"):
        TeensyEmulator(tmp_path / "other.elf")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """An image with the limits of the bench's sensors, and its words."""
    pytest.importorskip("ziglang", reason="the images are built by zig: install frictionloop[image]")
    words = firmware_words(bench("notch_pi"))
    return build("teensy31", words.tolist(), tmp_path_factory.mktemp("whole")).elf, words


@pytest.mark.parametrize("name", FAILURES)
def test_a_broken_sensor_is_the_image_s_fault_as_the_library_s(name, whole):
    """From mid-stroke 12 mm of a finger at 40 mm/s, then the failure: the same fault at the same tick."""
    elf, words = whole
    teensy, host, rng = TeensyEmulator(elf), HostBoard(words), np.random.default_rng(5)
    frames = hello() + encode("mode", 1, SESSION, state=schema()["states"]["closed"])
    decoders, found = (Decoder(), Decoder()), ([], [])
    pending = [frames[k : k + 40] for k in range(0, len(frames), 40)]
    teensy.receive(frames)
    lead, broke = 1700, None
    for k in range(lead + 300):
        sample = Sample(8000 + int(rng.integers(-3, 4)), 0, 8 * k - 8 * lead, 3277)
        if k == lead:
            broke = sample
        if k >= lead:
            sample = FAILURES[name].tells(sample, broke, k - lead, rng)
            sample = sample._replace(position=max(sample.position, -32000))
        if k % 500 == 499:
            teensy.receive(heartbeat(9 + k))
            host.receive(heartbeat(9 + k), 200 * k)
        teensy.tick((sample.force, sample.across), sample.load, sample.position)
        host.tick(sample, 200 * k)
        if pending:
            host.receive(pending.pop(0), 200 * k + 100)
        for decoder, sent, said in zip(decoders, (teensy.transmit(), host.transmit(200 * k + 100)), found, strict=True):
            said += [(m["fault"], m["tick"], m["value"]) for m in decoder.feed(sent) if m.name == "fault"]
    assert [named("faults")[fault] for fault, _, _ in found[0]] in [[fault] for fault in FAILURES[name].faults]
    assert found[0] == found[1]
