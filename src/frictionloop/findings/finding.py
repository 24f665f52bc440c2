"""One thing that a person should know of an answer: a code, a number, where it holds, and what to do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from frictionloop.findings.catalogue import SEVERITIES, Severity, explain
from frictionloop.findings.shown import Template, shown

Some = float | tuple[float, ...] | None


@dataclass(frozen=True, kw_only=True)
class Condition:
    """Where a finding holds; what is None or empty does not apply."""

    finger: int | str | None = None
    """Number of a finger in its population."""
    recording: str = ""
    channel: str = ""
    slip_length_um: Some = None
    speed_mm_s: Some = None
    load_n: Some = None
    force_n: Some = None
    occluded: float | None = None
    """How far occlusion has come: 0 just landed, 1 fully moist."""
    resonance_off: float | None = None
    """Share by which the sensor's resonance is off, above 0 where it is higher."""

    @property
    def values(self) -> dict[str, Any]:
        """What applies, by name."""
        pairs = ((each.name, getattr(self, each.name)) for each in fields(self))
        return {name: value for name, value in pairs if value is not None and value != ""}

    def __str__(self) -> str:
        """Return it for a person: slip 0 um, 20 mm/s, pressed 0.5 N, 39 % moist, resonance +10 %."""
        told = [f"finger {self.finger}"] if self.finger is not None else []
        told += [each for each in (self.recording, self.channel) if each]
        told += [f"slip {shown(self.slip_length_um)} um"] if self.slip_length_um is not None else []
        told += [f"{_each_or_ends(self.speed_mm_s)} mm/s"] if self.speed_mm_s is not None else []
        told += [f"pressed {shown(self.load_n)} N"] if self.load_n is not None else []
        told += [f"at {shown(self.force_n)} N"] if self.force_n is not None else []
        if self.occluded is not None:
            told.append(f"{100 * self.occluded:.0f} % moist" if self.occluded else "just landed")
        if self.resonance_off:
            told.append(f"resonance {100 * self.resonance_off:+.3g} %")
        return ", ".join(told)


def _each_or_ends(values: Any) -> str:
    """Return up to three values, or the ends of more."""
    many = isinstance(values, (list, tuple)) and len(values) > 3
    return f"{shown(min(values))} to {shown(max(values))}" if many else shown(values)


@dataclass(frozen=True)
class Finding:
    """One finding.

    >>> str(Finding("MS-BEYOND", value=3.31, limit=2.6, where=Condition(speed_mm_s=10.0, resonance_off=0.1)))
    'Ms 3.31, 2.6 asked: 10 mm/s, resonance +10 %'
    """

    code: str
    """Of the catalogue."""
    severity: Severity | None = None
    """That of the catalogue if not given."""
    value: Any = None
    unit: str = ""
    limit: Any = None
    where: Condition = Condition()
    remedy: Mapping[str, Any] | str = ""
    """Overrides for ``System.evolve``, or a command."""
    more: Mapping[str, Any] = field(default_factory=dict)
    """Further numbers of the template, by name."""

    def __post_init__(self) -> None:
        known = explain(self.code)
        object.__setattr__(self, "severity", self.severity or known.severity)

    def __str__(self) -> str:
        """Return it in one line."""
        given = {"value": self.value, "unit": self.unit, "limit": self.limit, "where": self.where, **self.more}
        said = Template().format(explain(self.code).template, remedy=shown(self.remedy), **given)
        return " ".join(said.split()).rstrip(":;, ")

    @property
    def rank(self) -> int:
        """0 of an error, 2 of a note."""
        return SEVERITIES.index(self.severity or "note")

    @classmethod
    def from_dict(cls, tree: Mapping[str, Any]) -> Finding:
        """Return a finding from what `to_dict` gave."""
        own = {name: tree[name] for name in ("severity", "value", "unit", "limit", "remedy") if name in tree}
        more = {name: value for name, value in tree.items() if name not in {*own, "code", "said", "where"}}
        return cls(tree["code"], **own, where=Condition(**tree.get("where", {})), more=more)

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name, with the line."""
        found: dict[str, Any] = {"code": self.code, "severity": self.severity, "said": str(self)}
        named = {"value": self.value, "unit": self.unit, "limit": self.limit, "remedy": self.remedy, **self.more}
        found |= {name: value for name, value in named.items() if value is not None and value != ""}
        return found | ({"where": where} if (where := self.where.values) else {})
