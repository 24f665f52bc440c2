"""Claims in words: a value with its unit, what is accepted, what a verdict rests on, and how many come out."""

from __future__ import annotations

import math
from collections.abc import Sequence

from frictionloop.report.claims.claim import COUNTED, SOME_READINGS, Claim, Group, Verdict
from frictionloop.report.numbers import shown, with_unit


def accepted(claim: Claim) -> str:
    """Return the numbers a claim accepts, in words."""
    low, high = claim.accepted
    low_text, high_text = (
        with_unit(end, claim.unit, claim.digits) if math.isfinite(end) else "" for end in (low, high)
    )
    if low == high:
        return low_text
    if math.isinf(high):
        return f"at least {low_text}"
    if math.isinf(low) or low == 0.0:
        return f"at most {high_text}"
    return f"{shown(low, claim.digits)} to {high_text}"


def condition(claim: Claim, most: int = 2) -> str:
    """Return what a claim that comes out in part rests on, a reading or an assumption, and ``most`` of their names."""
    if claim.verdict is not Verdict.ASSUMED:
        return ""
    readings = list(claim.readings)
    if claim.holds[readings[0]]:
        words, names = "comes out, but not as", [name for name in readings if not claim.holds[name]]
    elif set(claim.under) & set(readings):
        words, names = "comes out only if read as", [name for name in readings if claim.holds[name]]
    else:
        words, names = "comes out only assuming", claim.under
    # A reading that names its own unit, a variance in N², has its value in that.
    units = {name: "" if "(" in name.partition(",")[0] else claim.unit for name in names}
    told = [f"{name} ({with_unit(claim.all_values[name], units[name], claim.digits)})" for name in names[:most]]
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{words} {' or '.join(told)}{more}"


SYMBOLS = {
    Verdict.COMES_OUT: "✓",
    Verdict.ASSUMED: "◐",
    Verdict.NOT_OUT: "✗",
    Verdict.NOT_COUNTED: "·",
}
"""A sign beside each verdict, so that it does not rest on colour."""


def paper_and_ours(claim: Claim) -> tuple[str, str]:
    """Return what is printed and what comes out here, with units."""
    return with_unit(claim.published, claim.unit, claim.digits), with_unit(claim.ours, claim.unit, claim.digits)


def grouped(claims: Sequence[Claim]) -> dict[Group, list[Claim]]:
    """Return the claims of each group, in the order of the groups; groups without claims are left out."""
    found = {group: [claim for claim in claims if claim.group is group] for group in Group}
    return {group: some for group, some in found.items() if some}


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
