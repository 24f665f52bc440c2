"""What a tick costs, from a trace of the image; and the cost model on instructions whose cost the manual states."""

from importlib.metadata import version
from itertools import pairwise

import pytest
from tick_corpus import edges, heartbeat, opening, strokes
from tick_costs import cycles
from tick_cycles import CycleTrace

from frictionloop.control.cost import BUDGET_CYCLES, WORST_TICK
from frictionloop.device.emulator import TeensyEmulator

pytest.importorskip("unicorn", reason="install frictionloop[emulator]")
capstone = pytest.importorskip("capstone", reason="install frictionloop[emulator]")


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        ("0844", 1),  # add r0, r1
        ("4843", 1),  # muls r0, r1, r0
        ("00fb0120", 2),  # mla r0, r0, r1, r2
        ("80fb0123", 1),  # smull r2, r3, r0, r1
        ("90fbf1f0", 12),  # sdiv r0, r0, r1: 2 to 12
        ("0868", 2),  # ldr r0, [r1]
        ("d1e90023", 3),  # ldrd r2, r3, [r1]
        ("2de9f041", 7),  # push {r4-r8, lr}: 1 + 6
        ("bde8f081", 7),  # pop {r4-r8, pc}: 1 + 6, and the refill where it goes
        ("0860", 2),  # str r0, [r1]
        ("80fa81f0", 1),  # qadd r0, r1, r0
        ("7047", 1),  # bx lr, and the refill
        ("72b6", 2),  # cpsid i
    ],
)
def test_instructions_cost_what_the_manual_says(code, expected):
    (instruction,) = capstone.Cs(capstone.CS_ARCH_ARM, capstone.CS_MODE_THUMB | capstone.CS_MODE_MCLASS).disasm(
        bytes.fromhex(code), 0
    )
    assert cycles(instruction) == expected


def test_floating_point_has_no_cost():
    (instruction,) = capstone.Cs(capstone.CS_ARCH_ARM, capstone.CS_MODE_THUMB | capstone.CS_MODE_MCLASS).disasm(
        bytes.fromhex("30ee200a"), 0
    )
    with pytest.raises(ValueError, match="no floating-point unit"):
        cycles(instruction)


JUMPS = {"b", "bl", "blx", "bx", "cbz", "cbnz", "pop", "ldm", "tbb", "tbh"}


def issued(uc, visited):
    """Instructions from those that took effect: one more for each that an IT block skips, which takes its cycle."""
    disassembler = capstone.Cs(capstone.CS_ARCH_ARM, capstone.CS_MODE_THUMB | capstone.CS_MODE_MCLASS)
    count = len(visited)
    for (address, size), (after, _) in pairwise(visited):
        (here,) = disassembler.disasm(bytes(uc.mem_read(address, size)), address)
        if after != address + size and here.insn_name() not in JUMPS:
            skipped = bytes(uc.mem_read(address + size, after - address - size))
            count += len(list(disassembler.disasm(skipped, address + size)))
    return count


def test_the_trace_counts_every_instruction_of_the_interrupt(images):
    """Against unicorn's own hook at every instruction."""
    import unicorn

    emulator = TeensyEmulator(images("pi").elf)
    trace, visited = CycleTrace(emulator), []

    def visit(uc, address, size, _):
        if emulator.in_tick:
            visited.append((address, size))

    emulator.processor.uc.hook_add(unicorn.UC_HOOK_CODE, visit)
    emulator.processor.uc.ctl_flush_tb()
    emulator.receive(opening())
    for force, load, position in strokes(20):
        visited.clear()
        instructions = trace.tick(force, load, position).instructions
        assert instructions == issued(emulator.processor.uc, visited)


def most(image, count):
    """The most instructions and cycles of a tick: slow and quick strokes, and edges among them, in a closed loop."""
    trace = CycleTrace(emulator := TeensyEmulator(image.elf))
    emulator.receive(opening())
    samples = [*strokes(count, seed=1), *strokes(count, seed=1, speed_mm_s=80.0)]
    samples[50::37] = edges(len(samples[50::37]), seed=1)
    costs = []
    for k, (force, load, position) in enumerate(samples):
        if k % 500 == 499:
            emulator.receive(heartbeat(9 + k))
        costs.append(trace.tick(force, load, position))
    return max(cost.instructions for cost in costs), max(cost.cycles for cost in costs)


TRACED_WITH = "0.17.1"
"""The version of ziglang whose counts WORST_TICK holds; another compiler makes other code."""
MARGIN = 1.03
TARGET = 0.5
EXPERIMENTAL = {"tracker"}
"""Laws that nobody recommends, which may take more than the target."""


@pytest.mark.parametrize("law", ["notch_pi", *(pytest.param(law, marks=pytest.mark.slow) for law in WORST_TICK)])
def test_a_tick_keeps_to_its_budget(law, images):
    instructions, spent = most(images(law), 400)
    if version("ziglang") == TRACED_WITH:
        assert (instructions, spent) == WORST_TICK[law]
    assert instructions <= MARGIN * WORST_TICK[law].instructions
    assert spent <= MARGIN * WORST_TICK[law].cycles
    if law not in EXPERIMENTAL:
        assert spent <= TARGET * BUDGET_CYCLES


def test_the_default_law_takes_a_third_of_the_tick(images):
    assert most(images("notch_pi"), 400)[1] <= BUDGET_CYCLES // 3
