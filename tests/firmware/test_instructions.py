"""What a tick costs, from a trace of the image; and the cost model on instructions whose cost the manual states."""

from functools import cache
from importlib.metadata import version
from itertools import pairwise

import pytest

from frictionloop.control.cost import BUDGET_CYCLES, LATE_CYCLES, WORST_TICK
from frictionloop.device.emulator import TeensyEmulator
from frictionloop.device.emulator.budget import FLOODED, LINE_BYTES, opening, strokes, traced
from frictionloop.device.emulator.trace import ASSUMED, CycleTrace, cycles

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


@pytest.fixture(scope="module")
def budget(images):
    """What the image of a law takes, with two force axes."""
    return cache(lambda law: traced(images(law, axes=2).elf))


TRACED_WITH = "0.17.1"
"""The version of ziglang whose counts WORST_TICK holds; another compiler makes other code."""
MARGIN = 1.03
TARGET = 0.5


@pytest.mark.parametrize("law", ["notch_pi", *(pytest.param(law, marks=pytest.mark.slow) for law in WORST_TICK)])
def test_a_tick_keeps_to_its_budget(law, budget):
    found = budget(law)
    instructions, spent = max(tick.instructions for tick in found.ticks), found.worst.cycles
    if version("ziglang") == TRACED_WITH:
        assert (instructions, spent) == WORST_TICK[law]
    assert instructions <= MARGIN * WORST_TICK[law].instructions
    assert spent <= MARGIN * WORST_TICK[law].cycles
    assert spent <= TARGET * BUDGET_CYCLES


@pytest.mark.parametrize("law", ["notch_pi", *(pytest.param(law, marks=pytest.mark.slow) for law in WORST_TICK)])
def test_a_tick_with_any_effect_keeps_to_its_budget(law, budget):
    found = budget(law).table()["as assumed"]
    assert found["tick"] + 500 < found["effect"]  # it played
    assert found["effect"] <= TARGET * BUDGET_CYCLES
    whole = found["effect"] + found["interrupts"] + found["background"]
    assert (whole <= BUDGET_CYCLES) == (law != "filtered_pi")  # docs/effects.md tells of it


@pytest.mark.parametrize("law", ["notch_pi", *(pytest.param(law, marks=pytest.mark.slow) for law in WORST_TICK)])
def test_tick_interrupts_and_background_fit_into_a_period(law, budget):
    """The default law's also where flash or peripherals wait twice as long."""
    found = budget(law).table()
    for name, row in found.items():
        assert row["sum"] == row["tick"] + row["interrupts"] + row["background"]
        if law == "notch_pi" and name != "RAM waits a cycle":
            assert row["sum"] <= BUDGET_CYCLES, name
    assert found["as assumed"]["sum"] <= BUDGET_CYCLES
    assert max(row["tick"] for row in found.values()) < BUDGET_CYCLES


def test_an_interrupt_that_outranks_the_tick_makes_none_late(budget):
    """None follows at once: the next byte that calls for it is four bytes of the line away."""
    found = budget("notch_pi")
    assert 100 < max(spent.cycles for spent in found.interrupts) <= LATE_CYCLES
    assert 4 * BUDGET_CYCLES / LINE_BYTES > LATE_CYCLES
    assert len(found.interrupts) > 10 * FLOODED  # the line was full


def test_waits_add_up(budget):
    """Every part of the cost counts, and no more than it was counted."""
    tick = budget("notch_pi").worst
    for place, name in enumerate(ASSUMED._fields):
        more = ASSUMED._replace(**{name: getattr(ASSUMED, name) + 1})
        assert tick.under(more) - tick.under(ASSUMED) == tick[2 + place] >= 1


def test_the_default_law_takes_a_third_of_the_tick(budget):
    assert budget("notch_pi").worst.cycles <= BUDGET_CYCLES // 3
