"""What a tick costs: instructions of whole images, counted on an emulated Cortex-M7 that has double precision."""

from __future__ import annotations

import pytest

from frictionloop.control.cost import WORST_TICK
from frictionloop.device.bench_boards import HostBoard, Sample
from frictionloop.device.codec import encode
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.schema import schema
from tests.helpers.host_frames import NONCE, SESSION, heartbeat, hello

pytest.importorskip("unicorn", reason="install frictionloop[emulator]")
from frictionloop.firmware.emulated_core import EmulatedCore, counted

MOST, MOST_OF_A_LAW = 3000, 1000
MARGIN = 1.05
"""By how much an image may take more than what docs and comparisons tell (assumed: another version of zig)."""


@pytest.mark.parametrize("law", WORST_TICK)
def test_the_worst_tick_of_each_law_is_the_one_that_is_told(law: str, images):
    found = counted(images(law, axes=2).elf, 5000)
    assert WORST_TICK[law] / MARGIN <= found.tick <= MARGIN * WORST_TICK[law] <= MOST
    assert 50 < found.law <= MOST_OF_A_LAW


def test_the_emulator_is_a_processor_with_doubles_and_no_later_one(images):
    """vadd.f64 d0, d0, d1 runs; lda, of Armv8-M, does not (UC_MODE_MCLASS would run it: a Cortex-M33)."""
    unicorn = pytest.importorskip("unicorn")
    arm = pytest.importorskip("unicorn.arm_const")
    core = EmulatedCore(images("pi").elf)
    for name, code in (("fl_open_step", "30ee010b"), ("fl_look_up", "d0e8af0f")):
        core._cpu.mem_write(core.symbols[name], bytes.fromhex(code) + b"\x70\x47")  # and bx lr
    core.call("fl_open_step", doubles=(1.25, 2.5))
    assert core._cpu.reg_read(arm.UC_ARM_REG_D0) == 0x400E000000000000  # 3.75
    with pytest.raises(FrictionloopError, match="fl_look_up: .*instruction"):
        core.call("fl_look_up", core.symbols["fl_look_up"])
    assert unicorn.__version__.startswith("2.1.")


@pytest.mark.parametrize("law", ["pi", pytest.param("limit_observer", marks=pytest.mark.slow)])
def test_the_image_drives_as_the_library_of_this_machine(law: str, images, law_words):
    """Every duty and every bit of the amplitude, sensors failing now and then."""
    core, board, states = EmulatedCore(images(law).elf), HostBoard(law_words[law]), schema()["states"]
    major = schema()["protocol"]["major"]
    core.ask("hello", bytes([major]) + NONCE.to_bytes(4, "little"), 0)
    core.ask("mode", bytes([states["closed"]]), 0)
    board.receive(hello() + encode("mode", 1, SESSION, state=states["closed"]), 0)
    differ, seen = 0, set()
    for k in range(1, 8001):
        if k % 200 == 0:
            core.ask("heartbeat", b"", 200 * k)
            board.receive(heartbeat(k), 200 * k)
            board.transmit(200 * k)
        way = k % 2000 if k % 2000 < 1000 else 2000 - k % 2000
        sample = Sample(6000 + k * 7919 % 801 + (30_000 if k > 7900 else 0), 0, 16 * way - 8000, 0 if k % 3000 < 60 else 3277)
        drive = board.tick(sample, 200 * k)
        seen.add(drive.amplitude_um)
        differ += core.tick(sample, 200 * k) != (drive.duty, drive.amplitude_um)
    assert differ == 0 and len(seen) > 100 and board.last()[8] == 0.0
