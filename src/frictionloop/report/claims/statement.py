"""The statements that carry the paper: claims that one reading of the text has to make true together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from frictionloop.report.claims.claim import Claim, Condition, Verdict, texts


@dataclass(frozen=True, kw_only=True)
class Statement:
    """One line of the answer."""

    title: str
    claims: tuple[Claim, ...]
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
    rows = [row for row in texts("statements")["statement"] if set(row["claims"]) <= set(by_id)]
    return [_statement(row, by_id) for row in rows]


def _statement(row: Mapping[str, Any], by_id: Mapping[str, Claim]) -> Statement:
    some = tuple(by_id[id] for id in row["claims"])
    condition = tuple(row["condition"]) if "condition" in row else None
    number = row["number"].format_map({each.id: each.in_texts for each in some})
    return Statement(title=row["title"], claims=some, number=number, condition=condition)


def within(some: Iterable[Statement]) -> list[Claim]:
    """Return the claims that statements rest on."""
    return [claim for statement in some for claim in statement.claims]


def others(claims: Sequence[Claim]) -> list[Claim]:
    """Return the counted claims that no statement rests on."""
    resting = within(statements(claims))
    return [claim for claim in claims if claim.group is None and claim not in resting]
