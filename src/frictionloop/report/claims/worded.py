"""Claims in words: a value with its unit, what is accepted, and a sign for a verdict."""

from __future__ import annotations

import math

from frictionloop.report.claims.claim import Claim, Verdict
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


SYMBOLS = dict(zip(Verdict, "✓◐✗·", strict=True))
"""A sign beside each verdict, so that it does not rest on colour."""


def paper_and_ours(claim: Claim) -> tuple[str, str]:
    """Return what is printed and what comes out here, with units."""
    return with_unit(claim.published, claim.unit, claim.digits), with_unit(claim.ours, claim.unit, claim.digits)
