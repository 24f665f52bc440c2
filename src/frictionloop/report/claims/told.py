"""The claims as a terminal is told them, counted and in tables, and what the page says of them first."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

from frictionloop.report.cited import cited
from frictionloop.report.claims.claim import COUNTED, SOME_READINGS, THESIS, Claim, Group, Verdict
from frictionloop.report.claims.worded import accepted, condition, with_unit

if TYPE_CHECKING:
    from rich.table import Table


SYMBOLS = {
    Verdict.COMES_OUT: "✓",
    Verdict.ASSUMED: "◐",
    Verdict.NOT_OUT: "✗",
    Verdict.NOT_COUNTED: "·",
}
"""A sign beside each verdict, so that it does not rest on colour."""
COLOURS = {
    Verdict.COMES_OUT: "blue",
    Verdict.ASSUMED: "yellow",
    Verdict.NOT_OUT: "red",
    Verdict.NOT_COUNTED: "dim",
}


def paper_and_ours(claim: Claim) -> tuple[str, str]:
    """Return what is printed and what comes out here, with units."""
    return with_unit(claim.published, claim.unit, claim.digits), with_unit(claim.ours, claim.unit, claim.digits)


def claims_tables(claims: Sequence[Claim]) -> list[Table]:
    """Return the claims as ``rich`` tables for 80 columns, one per group: sign, statement with name, paper's, ours."""
    from rich.table import Table
    from rich.text import Text

    tables: list[Table] = []
    for group, some in grouped(claims).items():
        title = Text(counted(len(some), group), style="bold")
        table = Table(title=title, title_justify="left", box=None, padding=(0, 1, 0, 0), show_header=not tables)
        for name, width in (("", 1), ("statement", 33), ("paper", 14), ("here", 28)):
            table.add_column(name, width=width)
        for claim in some:
            sign = Text(SYMBOLS[claim.verdict], style=COLOURS[claim.verdict])
            published, ours = paper_and_ours(claim)
            named = Text(claim.title).append(f"\n{claim.id}", style="dim")
            table.add_row(sign, named, published, f"{claim.quantity}: {ours}{beside(claim)}")
        tables.append(table)
    return tables


def beside(claim: Claim) -> str:
    """Return what is accepted of a claim that is judged, and what it rests on if it comes out in part."""
    if claim.verdict is Verdict.NOT_COUNTED:
        return ""
    rests_on = condition(claim, most=1)
    return f"; accepted: {accepted(claim)}" + (f"; {rests_on}" if rests_on else "")


def grouped(claims: Sequence[Claim]) -> dict[Group, list[Claim]]:
    """Return the claims of each group, in the order of the groups; groups without claims are left out."""
    found = {group: [claim for claim in claims if claim.group is group] for group in Group}
    return {group: some for group, some in found.items() if some}


def claim_lines(claim: Claim) -> list[str]:
    """Return one claim for a terminal: the statement, the paper's value, and every number with whether it agrees.

    What is not a reading of the text says so: an assumption, or a number for comparison, which has no sign.
    """
    published, _ = paper_and_ours(claim)
    numbers = []
    for name, value in claim.all_values.items():
        sign = "·" if name in claim.compared else "✓" if claim.holds[name] else "✗"
        kind = "assuming " * (name in claim.assumed)
        beside = ", for comparison, without a vote" * (name in claim.compared)
        numbers.append(f"  {sign} {kind}{name}: {with_unit(value, claim.unit, claim.digits)}{beside}")
    return [
        f"{SYMBOLS[claim.verdict]} {claim.title} ({claim.place}): {claim.judged}",
        f"  paper: {published}; here: {claim.measure}; accepted: {accepted(claim)}",
        *numbers,
        *textwrap.wrap(claim.explanation, 88, initial_indent="  ", subsequent_indent="  "),
        f"  cite: {' · '.join(cited(claim.command, claim.seeds))}",
    ]


FIRST = ("open-loop-r2", "closed-loop-r2", "open-loop-variation", "steady-20-mn")
"""Claims of Fig. 5a that stand beside the paper's values at the top."""
HOLDS = {
    Verdict.COMES_OUT: "comes out",
    Verdict.ASSUMED: "comes out under an assumption",
    Verdict.NOT_OUT: "does not come out",
}
"""What is said of the paper's thesis."""


def counts(claims: Sequence[Claim]) -> dict[str, int]:
    """Return how many claims each group has, and how those of the device are judged."""
    found = {group.name.lower(): sum(claim.group is group for claim in claims) for group in Group}
    device = [claim.verdict for claim in claims if claim.group is Group.DEVICE]
    read = [claim.group for claim in claims if claim.judged == SOME_READINGS]
    return found | {
        "text": found["printed"] + found["assumed"] + found["not_out"],
        "counted": sum(claim.group in COUNTED for claim in claims),
        "device out": device.count(Verdict.COMES_OUT),
        "device part": device.count(Verdict.ASSUMED),
        "read": read.count(Group.ASSUMED),
        "device read": read.count(Group.DEVICE),
        "device not": device.count(Verdict.NOT_OUT),
    }


def counted(number: int, words: str) -> str:
    """Return a number and what is said of so many.

    >>> counted(1, "do not come out"), counted(2, "do not come out"), counted(1, "come out")
    ('1 does not come out', '2 do not come out', '1 comes out')
    """
    return f"{number} {_of_one(words) if number == 1 else words}"


def _of_one(words: str) -> str:
    return words.replace("do not", "does not") if "do not" in words else words.replace("come", "comes")


def summary(claims: Sequence[Claim]) -> list[str]:
    """Return what a terminal is told at the end."""
    n, thesis = counts(claims), next(claim for claim in claims if claim.id == THESIS)
    _, median = thesis.readings.values()
    return [
        "",
        f"The paper's idea {HOLDS[thesis.verdict]} with re-tuned gains: on one finger of the assumed bench the PI "
        f"divides the spread of the force by {thesis.ours:.3g}, over many in the median by {median:.3g}. "
        "The printed gains ring there.",
        f"{n['printed']} of {n['text']} statements about the simulation come out as printed, "
        f"{n['assumed']} under some readings or an assumption, {counted(n['not_out'], Group.NOT_OUT)}.",
        f"Of {n['device']} about the device {counted(n['device out'], 'come out')} on the assumed bench, "
        f"{n['device part']} under some readings or a further assumption, {counted(n['device not'], Group.NOT_OUT)}.",
        f"Not counted: {not_counted(claims)}.",
        "",
    ]


def not_counted(claims: Sequence[Claim]) -> str:
    """Return how many claims each group has that is not counted, in words."""
    return ", ".join(f"{len(some)} {group}" for group, some in grouped(claims).items() if group not in COUNTED)


def named(claims: Sequence[Claim]) -> dict[str, str]:
    """Return the titles of all that comes out, of the text and about the device, and of all that does not."""
    out = [claim for claim in claims if claim.verdict is Verdict.COMES_OUT]
    groups = {
        "out": [claim for claim in out if claim.group is not Group.DEVICE],
        "device out": [claim for claim in out if claim.group is Group.DEVICE],
        "not out": [claim for claim in claims if claim.verdict is Verdict.NOT_OUT],
    }
    return {name: _titles(some) for name, some in groups.items()}


def _titles(claims: Sequence[Claim]) -> str:
    return ", ".join(f"“{claim.title}”" for claim in claims)
