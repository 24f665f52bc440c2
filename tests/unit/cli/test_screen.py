"""Tables of a terminal: no number is cut, however narrow it is."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionloop.cli import screen

NAMES = ("re-tuned gains", "hold everywhere", "plate.frequency_hz = 25000")


def shown(rows, width):
    """Return the lines of a table on a terminal so wide."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", str(width))
        patch.setenv("LINES", "40")
        lines: list[str] = []
        patch.setattr("sys.stdout", type("File", (), {"write": lines.append, "flush": lambda: None}))
        screen.show(screen.table(rows))
    return "".join(lines).splitlines()


@given(
    numbers=st.lists(st.floats(1e-5, 1e5), min_size=1, max_size=12),
    width=st.integers(20, 120),
    words=st.sampled_from(["", "a note"]),
)
def test_no_number_of_a_table_is_cut_and_lines_are_longer_only_where_they_must_be(numbers, width, words):
    cells = [f"{each:.3g}" for each in numbers]
    lines = shown([(name, *cells, words) for name in NAMES], width)
    whole = [line.split() for line in lines if all(cell in line.split() for cell in cells)]
    assert len(whole) == len(NAMES)
    least = screen.NAME + sum(screen.GAP + len(cell) for cell in [*cells, words] if cell)
    assert max(map(len, lines)) <= max(min(width, screen.WIDEST), least)
