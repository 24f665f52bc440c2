"""What ``firmware build`` says of a table of cycles whose sums are beyond a tick."""

from __future__ import annotations

import pytest

from frictionloop.cli.firmware import _over
from frictionloop.control.cost import BUDGET_CYCLES


def row(tick, background):
    return {"tick": tick, "interrupts": 100, "background": background, "sum": tick + 100 + background}


def test_a_table_within_a_tick_says_nothing():
    assert _over({"as assumed": row(1000, 1000)}) == []


@pytest.mark.parametrize(("tick", "said"), [(5000, "ticks are on time then too"), (BUDGET_CYCLES, "TICKS ARE LATE")])
def test_what_exceeds_a_tick_is_named_with_what_it_means(tick, said):
    (line,) = _over({"as assumed": row(1000, 1000), "RAM waits": row(tick, BUDGET_CYCLES)})
    assert line.startswith(f"Above {BUDGET_CYCLES:,} in sum: RAM waits.") and said in line
