"""What a tick takes: instructions, counted on the image, against unicorn's own count; and the rate that they allow."""

import struct
from functools import cache
from itertools import pairwise

import pytest

from frictionloop.control.instruction_cost import BEYOND, CORE_HZ, CYCLES_AT_MOST, WORST_TICK, highest_rate_hz
from frictionloop.device.emulator import TeensyEmulator
from frictionloop.device.emulator.budget import opening, strokes, traced
from frictionloop.device.emulator.instruction_counts import LAW, InstructionTrace, count
from frictionloop.firmware.image_files import addresses

unicorn = pytest.importorskip("unicorn", reason="install frictionloop[emulator]")


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        ("0844", 1),  # add r0, r1
        ("00fb0120", 1),  # mla r0, r0, r1, r2
        ("30ee010b", 1),  # vadd.f64 d0, d0, d1
        ("08440844", 2),
        ("2de9f0410844bde8f081", 3),  # push {r4-r8, lr}; add; pop {r4-r8, pc}
        ("00f000f8 7047".replace(" ", ""), 2),  # bl; bx lr
        ("fee7", 1),  # b: 0b11100 is of 16 bits
    ],
)
def test_instructions_are_told_apart_by_their_length(code, expected):
    assert count(bytes.fromhex(code)) == expected


def issued(uc, visited):
    """Instructions from those that took effect: one more for each that an IT block passes over."""
    found = len(visited)
    for (address, size), (after, _) in pairwise(visited):
        (first,) = struct.unpack("<H", uc.mem_read(address, 2))
        jumps = first >> 12 in {0b1101, 0b1110, 0b1011, 0b0100} or size == 4
        if not jumps and after != address + size:
            found += count(bytes(uc.mem_read(address + size, after - address - size)))
    return found


def test_the_trace_counts_every_instruction_of_the_interrupt(images):
    """Against unicorn's own hook at every instruction; conditions that passed over some are few."""
    emulator = TeensyEmulator(images("pi").elf)
    trace, visited = InstructionTrace(emulator), []

    def visit(uc, address, size, _):
        if emulator.in_tick:
            visited.append((address, size))

    emulator.processor.uc.hook_add(unicorn.UC_HOOK_CODE, visit)
    emulator.processor.uc.ctl_flush_tb()
    emulator.receive(opening())
    for force, load, position in strokes(20):
        visited.clear()
        spent = trace.tick(force, load, position)
        assert len(visited) <= spent.instructions <= 1.1 * len(visited)
        assert spent.instructions >= issued(emulator.processor.uc, visited)


def test_the_law_is_what_runs_within_its_functions(images):
    elf = images("pi").elf
    emulator = TeensyEmulator(elf)
    trace, inside, within = InstructionTrace(emulator), [0], []
    starts = {place & ~1 for place in addresses(elf, LAW).values()}

    def visit(uc, address, size, _):
        if address in starts and not within:
            within.append(uc.reg_read(emulator.processor.arm.UC_ARM_REG_LR) & ~1)
        elif within and address == within[0]:
            within.clear()
        inside[0] += bool(within) and emulator.in_tick

    emulator.processor.uc.hook_add(unicorn.UC_HOOK_CODE, visit)
    emulator.processor.uc.ctl_flush_tb()
    emulator.receive(opening())
    for force, load, position in strokes(20):
        inside[0] = 0
        law = trace.tick(force, load, position).law
        assert inside[0] <= law <= 1.2 * inside[0]
    assert law > 30


@pytest.fixture(scope="module")
def budget(images):
    """What the image of a law takes, with two force axes."""
    return cache(lambda law: traced(images(law, axes=2).elf))


@pytest.mark.parametrize("law", ["notch_pi", *(pytest.param(law, marks=pytest.mark.slow) for law in WORST_TICK)])
def test_a_tick_keeps_to_its_budget(law, budget):
    """In 200 us at 20 cycles an instruction, with any effect too."""
    found = budget(law)
    assert found.tick == pytest.approx(WORST_TICK[law], rel=0.03)  # another compiler makes other code
    assert found.tick + 200 < found.effect  # it played
    assert found.law <= 1000
    assert highest_rate_hz(found.effect) > (5000 if law != "filtered_pi" else 4900)


def test_ticks_interrupts_and_background_fit_into_a_period_at_fewer_cycles(budget):
    found = budget("notch_pi")
    assert 400 < found.interrupts < 3000 and 400 < found.background < 3000
    assert BEYOND * highest_rate_hz(found.tick + found.interrupts + found.background) > 2 * 5000


def test_the_highest_rate_is_the_clock_over_the_cycles_of_a_tick():
    assert highest_rate_hz(CORE_HZ // CYCLES_AT_MOST // 5000) == 5000
