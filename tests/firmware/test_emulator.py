"""The flashable image in the emulated Teensy."""

import math
import struct

import numpy as np
import pytest
from broken_sensors import FAILURES, bench

import frictionloop as fl
from frictionloop import FrictionloopError
from frictionloop.control.laws import LAWS
from frictionloop.device.codec import Decoder, encode
from frictionloop.device.emulator import TeensyEmulator
from frictionloop.device.emulator.budget import SESSION, edges, heartbeat, hello, opening, strokes
from frictionloop.device.emulator.peripherals import CORE_HZ, converted
from frictionloop.device.emulator.processor import is_floating_point
from frictionloop.device.emulator.registers import Bank
from frictionloop.device.simulated_boards import HostBoard, Sample
from frictionloop.firmware.image import build
from frictionloop.firmware.image_law import board_law
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.loop.registered_blocks import forget
from frictionloop.quantities.protocol_schema import named, schema
from tests.helpers.own_laws import register_both

unicorn = pytest.importorskip("unicorn", reason="install frictionloop[emulator]")
arm_const = pytest.importorskip("unicorn.arm_const", reason="install frictionloop[emulator]")

PERIOD, PI = 2870, board_law(LAWS["pi"])


@pytest.fixture
def board(images):
    return TeensyEmulator(images("pi").elf)


def fields(message):
    return message.name, {name: np.asarray(value).tolist() for name, value in message.fields.items()}


def test_clocks_tick_carrier_and_port_are_those_of_the_design(board):
    assert board.frequencies() == (396e6, 132e6, 24e6, 24e6)
    assert board._bank.values["PIT_LDVAL0"] + 1 == 24e6 / 5000 and board.tick_hz == 5000
    assert board.period == PERIOD
    assert board.baud() == 2e6


def test_the_carrier_is_off_until_a_host_closes_the_loop(board):
    assert [board.tick((9000, 0), 3277, 4 * k) for k in range(50)] == [0.0] * 50


def test_the_identity_is_told(board):
    board.receive(encode("identify", 7))
    for _ in range(3):
        board.tick((0, 0), 0, 0)
    (identity,) = Decoder().feed(board.transmit())
    assert identity.name == "identity"
    assert identity["board"] == schema()["boards"]["teensy41"]
    assert identity["tick_hz"] == 5000


@pytest.fixture
def own_laws():
    register_both()
    yield
    forget()


def read_by(board_name, force, load, position):
    """Return what the image reads of a sample: its converters on the chip have 12 bits, the ADS8688 has 16."""
    sample = Sample(*force, position, load)
    return sample if board_name.endswith("ads8688") else Sample(*map(converted, sample))


@pytest.mark.parametrize(
    ("law", "period", "name"),
    [
        ("pi", PERIOD, "teensy41"), ("notch_pi", PERIOD, "teensy41"), ("limit_observer", PERIOD, "teensy41"),
        ("pi", 13200, "teensy41"), ("pi", 2640, "teensy41"), ("pi", PERIOD, "teensy41-ads8688"),
        ("dead_band_pi", PERIOD, "teensy41"),
    ],
)  # fmt: skip
def test_every_duty_is_the_host_librarys(law, period, name, law_words, own_laws, tmp_path):
    """The same bits in the processor's carrier as in this machine's library, compare value by compare value."""
    words = law_words[law] if law in law_words else firmware_words(fl.bench().evolve({"controller.kind": law}))
    ours = build(name, words.tolist(), board_law(LAWS[law]), tmp_path, rate_hz=5000, carrier_ticks=period)
    teensy, host = TeensyEmulator(ours.elf), HostBoard(words)
    pending = [opening()[k : k + 40] for k in range(0, len(opening()), 40)]
    teensy.receive(opening())
    told, heard = Decoder(), Decoder()
    seen, expected, closed = [], [], 0
    for k, (force, load, position) in enumerate([*strokes(600, seed=3), *edges(100, seed=4)]):
        duty = teensy.tick(force, load, position)
        drive = host.tick(read_by(name, force, load, position), 200 * k)
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


@pytest.mark.parametrize("rate_hz", [1000, 1600, 15625, 20000])
def test_the_board_ticks_at_any_rate_of_an_image(rate_hz, tmp_path):
    """Timer, line and converters are those of the rate, and every duty is the library's."""
    words = firmware_words(fl.bench().evolve(fl.RETUNED | {"controller.rate_hz": float(rate_hz)}))
    teensy = TeensyEmulator(build("teensy41", words.tolist(), PI, tmp_path, rate_hz=rate_hz).elf)
    host, tick_us, line = HostBoard(words, rate_hz=rate_hz), 1_000_000 // rate_hz, int(200_000 / rate_hz)
    frames = hello() + encode("mode", 1, SESSION, state=schema()["states"]["closed"])
    pending = [frames[k : k + line] for k in range(0, len(frames), line)]
    teensy.receive(frames)
    assert teensy.tick_hz == rate_hz and teensy.baud() == 2e6
    duties = set()
    for k in range(rate_hz // 8):
        force, position = (8000 + 16 * (k * 7919 % 101), 0), round(20_000 * k / rate_hz)
        teensy.tick(force, 3277, position)
        drive = host.tick(read_by("teensy41", force, 3277, position), tick_us * k)
        assert teensy.compare == (2 * drive.duty * PERIOD + 2**17 - 1) // 2**18
        duties.add(teensy.compare)
        if pending:
            host.receive(pending.pop(0), tick_us * k + tick_us // 2)
    assert len(duties) > 20


@pytest.mark.parametrize("counts", [-32768, -17, -16, -1, 0, 15, 16, 12345, 32751, 32752, 32767])
def test_a_step_of_twelve_bits_is_sixteen_and_the_ends_stay_ends(counts):
    assert converted(counts) == (32767 if counts >= 32752 else 16 * math.floor(counts / 16))


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


def test_the_longest_tick_is_told_in_microseconds(board):
    """From the counter of cycles: 396 a microsecond, in steps of 1/256."""
    for lasts_us in (20.0, 37.5, 10.0):
        board.lasts_us = lasts_us
        board.tick((0, 0), 0, 0)
    board.receive(encode("statistics", 1))
    for _ in range(4):
        board.tick((0, 0), 0, 0)
    (counted,) = Decoder().feed(board.transmit())
    assert counted["longest_us"] == 37.5 * 256


@pytest.mark.parametrize(("old", "new"), [("07002000", "03002000"), ("abaaaaaa", "aaaaaaaa")])
def test_an_image_without_its_memory_faults(old, new, images, tmp_path):
    """FlexRAM not shared out by the register; all of it for data."""
    content = images("pi").elf.read_bytes()
    assert bytes.fromhex(old) in content
    (tmp_path / "without.elf").write_bytes(content.replace(bytes.fromhex(old), bytes.fromhex(new)))
    with pytest.raises(FrictionloopError, match=r"faults at 0x6000\w+: Invalid memory write"):
        TeensyEmulator(tmp_path / "without.elf")


def closed(board):
    board.receive(opening())
    for force, load, position in strokes(200):
        board.tick(force, load, position)
    assert board.duty > 0


def test_a_hard_fault_switches_the_carrier_off(board):
    closed(board)
    handler = board.processor.vector(16 + 122) & ~1
    board.processor.uc.mem_write(handler, b"\x00\xde")  # UDF, an instruction that is none
    board.processor.uc.ctl_flush_tb()
    with pytest.raises(FrictionloopError, match=f"faults at 0x{handler:08x}"):
        board.tick((0, 0), 0, 0)
    assert board.duty == 0
    with pytest.raises(FrictionloopError, match="faults at"):
        board.tick((0, 0), 0, 0)


def test_an_unknown_register_ends_the_run(board):
    closed(board)
    handler = board.processor.vector(16 + 122) & ~1
    # movw r0, #0x4100; movt r0, #0x4008; ldrh r0, [r0]: half of PIT_LDVAL0
    code = bytes.fromhex("44f20010 c4f20800 0088".replace(" ", ""))
    board.processor.uc.mem_write(handler, code)
    board.processor.uc.ctl_flush_tb()
    with pytest.raises(FrictionloopError, match="reads 0x40084100, 2 bytes: no register"):
        board.tick((0, 0), 0, 0)


def test_a_block_without_its_clock_is_out_of_reach():
    bank = Bank()
    with pytest.raises(FrictionloopError, match=r"reads PIT_CVAL0: clock off, CCM_CCGR1 bit 12"):
        bank.read(0x40084104, 4)
    bank.write(0x400FC06C, 4, 3 << 12)
    assert bank.read(0x40084104, 4) == 0
    bank.write(0x400FC06C, 4, 1 << 12)
    with pytest.raises(FrictionloopError, match="writes PIT_MCR: clock off"):
        bank.write(0x40084000, 4, 0)


@pytest.mark.parametrize(
    ("register", "value", "says"),
    [
        ("ADC_ETC_TRIG0_COUNTER", 6000, "ADC1: not done in a tick"),
        ("ADC2_CFG", 2 << 2 | 1 | 3 << 5 | 3 << 14, "ADC2: not done in a tick"),
        ("ADC_ETC_TRIG4_CHAIN_1_0", 0x10231017, r"TRIG4_CHAIN_1_0 = 0x10231017: nothing connected"),
        ("CCM_CBCDR", 1 << 8, "bus = 198 MHz: must be at most 150"),
    ],
)
def test_converters_that_miss_the_tick_are_refused(board, register, value, says):
    board._bank.values[register] = value
    with pytest.raises(FrictionloopError, match=says):
        board._converters.start()


def test_the_watchdog_counts_with_its_prescaler(board):
    board._bank.values["RTWDOG_CS"] |= 1 << 12
    assert board._watchdog.timeout_s() == pytest.approx(12.8, rel=1e-3)


def test_a_chip_with_another_clock_is_left_alone(images, monkeypatch):
    """The image compares its core with the crystal, and stops."""
    monkeypatch.setattr("frictionloop.device.emulator.peripherals.CORE_HZ", CORE_HZ * 528 // 396)
    with pytest.raises(FrictionloopError, match="has stopped itself, carrier off"):
        TeensyEmulator(images("pi").elf)


def run(code):
    """Run an instruction where the emulator runs images."""
    uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB)
    uc.ctl_set_cpu_model(arm_const.UC_CPU_ARM_CORTEX_M7)
    uc.mem_map(0x1000, 4096)
    uc.mem_write(0x1000, code)
    uc.reg_write(arm_const.UC_ARM_REG_R1, 0x1100)
    for place in (arm_const.UC_ARM_REG_D0, arm_const.UC_ARM_REG_D1):
        uc.reg_write(place, struct.unpack("<Q", struct.pack("<d", 0.1))[0])
    uc.emu_start(0x1001, 0x1000 + len(code))
    return struct.unpack("<d", struct.pack("<Q", uc.reg_read(arm_const.UC_ARM_REG_D0)))[0]


def test_the_processor_adds_doubles_and_has_nothing_of_armv8():
    """A Cortex-M4 or M33 has no doubles (VADD.F64 d0, d0, d1), a Cortex-M7 no load-acquire (LDA r0, [r1])."""
    assert run(bytes.fromhex("30ee010b")) == 0.2
    with pytest.raises(unicorn.UcError, match="Invalid instruction"):
        run(bytes.fromhex("d1e8af0f"))


@pytest.mark.parametrize(
    ("code", "is_one"),
    [
        ("30ee010b", True),  # vadd.f64 d0, d0, d1
        ("30ee200a", True),  # vadd.f32 s0, s0, s1
        ("91ed000b", True),  # vldr d0, [r1]
        ("2ded108b", True),  # vpush {d8-d15}
        ("f1ee100a", True),  # vmrs r0, fpscr
        ("51ec300b", True),  # vmov r0, r1, d16
        ("80fb0123", False),  # smull r2, r3, r0, r1
        ("d1e90023", False),  # ldrd r2, r3, [r1]
        ("eff31080", False),  # mrs r0, primask
        ("10ee100f", False),  # mrc p15
        ("0844", False),  # add r0, r1
    ],
)
def test_what_is_floating_point_is_known_by_its_coprocessor(code, is_one):
    assert is_floating_point(bytes.fromhex(code)) == is_one


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("4ff47001", "4ff00001", "floating point not switched on, CPACR"),  # mov.w r1, #0xF00000: #0
        ("72b63648", "30ee010b", r"0x6000\w+ before CPACR is written"),  # the first two instructions: vadd.f64
    ],
)
def test_an_image_without_floating_point_is_refused(old, new, says, images, tmp_path):
    content = images("pi").elf.read_bytes()
    assert bytes.fromhex(old) in content
    (tmp_path / "without.elf").write_bytes(content.replace(bytes.fromhex(old), bytes.fromhex(new)))
    with pytest.raises(FrictionloopError, match=says):
        TeensyEmulator(tmp_path / "without.elf")


def test_an_image_that_leaves_the_watchdog_alone_is_refused(images, tmp_path):
    content = images("pi").elf.read_bytes()
    assert movw(0xC520) in content
    spoilt = tmp_path / "spoilt.elf"
    spoilt.write_bytes(content.replace(movw(0xC520), movw(0xC521)))
    with pytest.raises(FrictionloopError, match="watchdog: 0xd928c521 is none of its words"):
        TeensyEmulator(spoilt)


def movw(value):
    """The first three bytes of MOVW Rd, #value but for Rd: ARMv7-M A7.7.76, encoding T3."""
    imm4, i, imm3, imm8 = value >> 12, value >> 11 & 1, value >> 8 & 7, value & 255
    first, second = 0xF240 | i << 10 | imm4, imm3 << 12 | imm8
    return first.to_bytes(2, "little") + bytes([second & 255])


def test_an_image_of_another_board_is_one_line(images, tmp_path):
    content = images("pi").elf.read_bytes()
    (tmp_path / "other.elf").write_bytes(content.replace(b"FCFB", b"FCFA"))
    with pytest.raises(FrictionloopError, match=r"other\.elf: is no image of a Teensy 4\.1"):
        TeensyEmulator(tmp_path / "other.elf")
    with pytest.raises(FrictionloopError, match=r"mps2\.elf: is no image of a Teensy 4\.1"):
        TeensyEmulator(images("pi", board="mps2").elf)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """An image with the limits of the bench's sensors, and its words."""
    pytest.importorskip("ziglang", reason="the images are built by zig: install frictionloop[image]")
    words = firmware_words(bench("notch_pi"))
    return build(
        "teensy41", words.tolist(), board_law(LAWS["notch_pi"]), tmp_path_factory.mktemp("whole"), rate_hz=5000
    ).elf, words


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
    for k in range(lead + 1000):
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
        host.tick(Sample(*map(converted, sample)), 200 * k)
        if pending:
            host.receive(pending.pop(0), 200 * k + 100)
        for decoder, sent, said in zip(decoders, (teensy.transmit(), host.transmit(200 * k + 100)), found, strict=True):
            said += [(m["fault"], m["tick"], m["value"]) for m in decoder.feed(sent) if m.name == "fault"]
    assert [named("faults")[fault] for fault, _, _ in found[0]] in [[fault] for fault in FAILURES[name].faults]
    assert found[0] == found[1]
