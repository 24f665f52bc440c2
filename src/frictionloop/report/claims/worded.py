"""A claim's numbers in words: a value with its unit, what is accepted, and what a verdict in part rests on."""

from __future__ import annotations

import math

from frictionloop.report.claims.claim import Claim, Verdict
from frictionloop.report.numbers import number

NEARLY_ONE = 0.9999
"""A number above this and below 1 is shown as what is missing from 1."""


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
