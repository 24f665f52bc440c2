"""The claims as a table for a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from frictionloop.report.claims.claim import Claim, Verdict
from frictionloop.report.numbers import number

if TYPE_CHECKING:
    from rich.table import Table

NEARLY_ONE = 0.9999
"""A number above this and below 1 is shown as what is missing from 1."""
SYMBOLS = {
    Verdict.REPRODUCED: "✓",
    Verdict.NOT_REPRODUCED: "✗",
    Verdict.READING_DEPENDENT: "◐",
    Verdict.OTHER_GAINS: "↻",
}
"""A sign beside each verdict, so that it does not rest on colour."""
COLOURS = {
    Verdict.REPRODUCED: "blue",
    Verdict.NOT_REPRODUCED: "red",
    Verdict.READING_DEPENDENT: "yellow",
    Verdict.OTHER_GAINS: "magenta",
}


def shown(value: float | str | None, digits: int = 3) -> str:
    """Return a value of a claim as it is printed in tables: just below 1 as what is missing.

    >>> shown(0.999995), shown(0.98)
    ('1 − 5×10⁻⁶', '0.98')
    """
    if value is None:
        return "none"
    if isinstance(value, str):
        return value
    if NEARLY_ONE < value < 1 and number(value, digits) == "1":
        return f"1 − {number(1 - value, 2)}"
    return number(value, digits)


def with_unit(value: float | str | None, unit: str, digits: int = 3) -> str:
    """Return a value with its unit, which only a number carries."""
    text = shown(value, digits)
    return f"{text} {unit}".strip() if isinstance(value, (int, float)) else text


def paper_and_ours(claim: Claim) -> tuple[str, str]:
    """Return what is printed and what comes out here, with units."""
    return with_unit(claim.published, claim.unit, claim.digits), with_unit(claim.ours, claim.unit, claim.digits)


def claims_table(claims: Sequence[Claim]) -> Table:
    """Return the claims as a ``rich`` table, narrow enough for 80 columns: sign, statement, the paper's value, ours."""
    from rich.table import Table
    from rich.text import Text

    count = {verdict: sum(claim.verdict == verdict for claim in claims) for verdict in Verdict}
    key = Text("   ").join(Text(f"{SYMBOLS[v]} {count[v]} {v}", style=COLOURS[v]) for v in Verdict)
    table = Table("", "statement", "paper", "here", title=key, title_justify="left", box=None, padding=(0, 1, 0, 0))
    for claim in claims:
        sign = Text(SYMBOLS[claim.verdict], style=COLOURS[claim.verdict])
        table.add_row(sign, claim.title, *paper_and_ours(claim))
    return table
