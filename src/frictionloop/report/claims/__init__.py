"""The paper's claims as data, each with a verdict that its numbers decide."""

from __future__ import annotations

from frictionloop.report.claims import (
    amplitude,
    characterisation,
    closed_loop,
    equation3,
    errors,
    gains,
    model,
    noise,
    people,
    plate,
    sensor,
    steps,
    tracking,
)
from frictionloop.report.claims.beyond import beyond_claims
from frictionloop.report.claims.claim import Claim, Verdict
from frictionloop.report.claims.table import claims_table
from frictionloop.report.results import Results

__all__ = ["Claim", "Verdict", "all_claims", "claims_table"]

TOPICS = (
    *(gains, tracking, noise, equation3, model),
    *(sensor, characterisation, plate),
    *(closed_loop, errors, steps, amplitude, people),
)
"""In the order of the paper; each has its ``CLAIMS``, which take the results."""


def all_claims(results: Results) -> list[Claim]:
    """Return every claim in the order of the paper's topics."""
    return [*(claim(results) for topic in TOPICS for claim in topic.CLAIMS), *beyond_claims(results.beyond)]
