"""The claims as a table for a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from frictionloop.report.claims.claim import Claim, Verdict
from frictionloop.report.numbers import number

if TYPE_CHECKING:
    from rich.table import Table

SYMBOLS = {Verdict.REPRODUCED: "✓", Verdict.NOT_REPRODUCED: "✗", Verdict.READING_DEPENDENT: "◐"}
"""A sign beside each verdict, so that it does not rest on colour."""
COLOURS = {Verdict.REPRODUCED: "blue", Verdict.NOT_REPRODUCED: "red", Verdict.READING_DEPENDENT: "yellow"}


def shown(value: float | str | None) -> str:
    """Return a value of a claim as it is printed in tables."""
    if value is None:
        return "none"
    return value if isinstance(value, str) else number(value)


def with_unit(value: float | str | None, unit: str) -> str:
    """Return a value with its unit, which only a number carries."""
    return f"{shown(value)} {unit}".strip() if isinstance(value, (int, float)) else shown(value)


def claims_table(claims: Sequence[Claim]) -> Table:
    """Return the claims as a ``rich`` table, narrow enough for 80 columns: sign, statement, the paper's value, ours."""
    from rich.table import Table
    from rich.text import Text

    count = {verdict: sum(claim.verdict == verdict for claim in claims) for verdict in Verdict}
    key = Text("   ").join(Text(f"{SYMBOLS[v]} {count[v]} {v}", style=COLOURS[v]) for v in Verdict)
    table = Table("", "statement", "paper", "here", title=key, title_justify="left", box=None, padding=(0, 1, 0, 0))
    for claim in claims:
        sign = Text(SYMBOLS[claim.verdict], style=COLOURS[claim.verdict])
        table.add_row(sign, claim.title, shown(claim.published), with_unit(claim.ours, claim.unit))
    return table
