"""The paper's claims: texts in TOML files, numbers from the module of the same name, and verdicts from both.

The statements that carry the paper are claims that one reading of the text has to make true together.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from frictionloop.report.claims import device_claims, noise_claims, sensor_claims, simulation_claims, step_claims
from frictionloop.report.claims.claim import COUNTED, Claim, Condition, Group, Verdict, judged, texts
from frictionloop.report.results import Results

TOPICS = {
    "simulation": simulation_claims,
    "noise": noise_claims,
    "sensor": sensor_claims,
    "device": device_claims,
    "steps": step_claims,
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


@dataclass(frozen=True, kw_only=True)
class Statement:
    """One line of the answer."""

    title: str
    claims: tuple[Claim, ...]
    labels: tuple[str, ...] = ()
    """What each of them says, in a word or two."""
    number: str
    """A number, and where it holds."""
    condition: Condition | None = None

    @property
    def verdict(self) -> Verdict:
        """Yes if every claim is yes, or holds under the condition; else no."""
        if self.condition is None:
            return Verdict.YES if all(each.verdict is Verdict.YES for each in self.claims) else Verdict.NO
        part = self.condition[0]
        true = all(each.verdict is Verdict.YES or each.holds_under(part) for each in self.claims)
        return Verdict.YES_IF if true else Verdict.NO

    @property
    def verdict_text(self) -> str:
        """The verdict with its condition."""
        return self.verdict.under(self.condition)

    def to_dict(self) -> dict[str, Any]:
        """Return the statement for JSON, its claims by their ids."""
        found = {name: getattr(self, name) for name in ("title", "number")}
        return found | {"verdict": self.verdict_text, "claims": [each.id for each in self.claims]}


def statements(claims: Sequence[Claim]) -> list[Statement]:
    """Return the statements all of whose claims are there, in the order of the page."""
    by_id = {claim.id: claim for claim in claims}
    rows = [row for row in texts("statements")["statement"] if row["claims"].keys() <= by_id.keys()]
    return [_statement(row, by_id) for row in rows]


def _statement(row: Mapping[str, Any], by_id: Mapping[str, Claim]) -> Statement:
    some, labels = tuple(by_id[id] for id in row["claims"]), tuple(row["claims"].values())
    condition = tuple(row["condition"]) if "condition" in row else None
    number = row["number"].format_map({each.id: each.in_texts for each in some})
    return Statement(title=row["title"], claims=some, labels=labels, number=number, condition=condition)


def within(some: Iterable[Statement]) -> list[Claim]:
    """Return the claims that statements rest on."""
    return [claim for statement in some for claim in statement.claims]


def others(claims: Sequence[Claim]) -> list[Claim]:
    """Return the counted claims that no statement rests on."""
    resting = within(statements(claims))
    return [claim for claim in claims if claim.group is None and claim not in resting]
