"""The paper's claims as data, each with a verdict that its numbers decide."""

from __future__ import annotations

from frictionloop.report.claims import (
    amplitude,
    beyond,
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
    thesis,
    tracking,
)
from frictionloop.report.claims.claim import COUNTED, Claim, Group, Verdict
from frictionloop.report.claims.table import claims_tables
from frictionloop.report.results import Results

__all__ = ["COUNTED", "Claim", "Group", "Verdict", "all_claims", "claims_tables"]

TOPICS = (
    thesis,
    *(gains, tracking, noise, equation3, model),
    *(sensor, characterisation, plate),
    *(closed_loop, errors, steps, amplitude, people, beyond),
)
"""The paper's thesis, then the order of the paper; each has its ``CLAIMS``, which take the results."""


def all_claims(results: Results) -> list[Claim]:
    """Return every claim, the paper's thesis first."""
    return [claim(results) for topic in TOPICS for claim in topic.CLAIMS]
