"""The paper's claims: texts in TOML files, numbers from the module of the same name, and verdicts from both."""

from __future__ import annotations

from frictionloop.report.claims import device, noise, sensor, simulation, steps
from frictionloop.report.claims.claim import COUNTED, Claim, Group, Verdict, judged, texts
from frictionloop.report.claims.statement import Statement, others, statements, within
from frictionloop.report.results import Results

TOPICS = {
    "simulation": simulation,
    "noise": noise,
    "sensor": sensor,
    "device": device,
    "steps": steps,
}


def claim_ids() -> list[str]:
    """Return the names of all claims, in the order of the paper."""
    return [id for topic in TOPICS for id in texts(topic)]


def one_claim(id: str, results: Results) -> Claim:
    """Return one claim, computing only what it needs."""
    topic = next(topic for topic in TOPICS if id in texts(topic))
    watched = results.watched()
    found = getattr(TOPICS[topic], id.replace("-", "_"))(watched)
    return judged(id, texts(topic)[id], found, watched.seeds())


def all_claims(results: Results) -> list[Claim]:
    """Return every claim."""
    return [one_claim(id, results) for id in claim_ids()]
