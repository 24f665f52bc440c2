"""The paper's claims: texts in TOML files, numbers from the module of the same name, and verdicts from both."""

from __future__ import annotations

from collections.abc import Iterator

from frictionloop.report.claims import device, noise, sensor, simulation, steps
from frictionloop.report.claims.claim import COUNTED, THESIS, Claim, Group, Verdict, judged, texts
from frictionloop.report.claims.statement import Statement, others, statements, within
from frictionloop.report.results import Results

TOPICS = {
    "simulation": simulation,
    "noise": noise,
    "sensor": sensor,
    "device": device,
    "steps": steps,
}


def _by_id() -> Iterator[tuple[str, str]]:
    """Yield id and topic of every claim: the thesis, then the order of the paper."""
    found = {id: topic for topic in TOPICS for id in texts(topic)}
    yield THESIS, found.pop(THESIS)
    yield from found.items()


def claim_ids() -> list[str]:
    """Return the names of all claims, the thesis first."""
    return [id for id, _ in _by_id()]


def one_claim(id: str, results: Results) -> Claim:
    """Return one claim, computing only what it needs."""
    topic = dict(_by_id())[id]
    watched = results.watched()
    found = getattr(TOPICS[topic], id.replace("-", "_"))(watched)
    return judged(id, texts(topic)[id], found, watched.seeds())


def all_claims(results: Results) -> list[Claim]:
    """Return every claim, the paper's thesis first."""
    return [one_claim(id, results) for id in claim_ids()]
