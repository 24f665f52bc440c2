"""Which law a comparison recommends, and why: one that bears its device, the default unless another is better."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from frictionloop.design.comparison.law_margins import Row
from frictionloop.design.loop_gains import MOST_PEAK
from frictionloop.findings import Condition, Finding

Rows = Sequence[Row]
DEFAULT = "notch_pi"
"""The law that is recommended unless another leaves less by more than fingers differ (docs/which-law.md)."""
NEVER = {"lookup", "printed_pi"}
"""Not recommended: no control, and gains for another device."""
ROUGHER = 1.3
"""Ratio of what touch feels under two laws from which it is told (chosen)."""
MOST_PEAK_OFF = 4.0
"""Largest Ms on a finger of the largest gain with the resonance 10 % lower (assumed)."""
ENOUGH = 10
"""Capable fingers at each speed below which nothing is recommended: the worst decile of fewer is a single finger."""


class Left(NamedTuple):
    """What a law leaves where it leaves the most: over fingers, at one speed and slip length."""

    worst_n: float
    """Worst decile of the residual, N."""
    median_n: float

    @property
    def scatter_n(self) -> float:
        """How far fingers are apart: from the median to the worst decile, N."""
        return self.worst_n - self.median_n


def recommended(rows: Rows, margins: Rows) -> tuple[str | None, tuple[Finding, ...]]:
    """Return the law to take, None if none is, and what decides it.

    Of those stable with the resonance 5 % off it is the default, or one that is clearly better; where the default does
    not bear the fingers of the largest gain, the best of those that do.
    """
    if few := too_few(rows):
        return None, (few,)
    left = left_by(rows)
    rings = {law: _unstable_at(margins, law, 5) for law in left}
    stable = {law: each for law, each in left.items() if rings[law] is None}
    if not stable:
        return None, tuple(each for each in rings.values() if each is not None)
    loud = _loud(margins, DEFAULT) if DEFAULT in stable else None
    if loud is not None and (calm := {law: each for law, each in stable.items() if _loud(margins, law) is None}):
        law = min(calm, key=lambda name: calm[name].worst_n)
        found = [loud, *_rougher(rows, law, [each for each in stable if each != law]), _unstable_at(margins, law, 10)]
        return law, tuple(each for each in found if each is not None)
    best = min(stable, key=lambda law: stable[law].worst_n)
    law = best
    if DEFAULT in stable:
        default = stable[DEFAULT]
        law = best if default.worst_n - stable[best].worst_n > default.scatter_n else DEFAULT
    found = [_close(stable, law, best)] if DEFAULT in stable and best != DEFAULT else [rings.get(DEFAULT)]
    found += [*_rougher(rows, law, [each for each in stable if each != law]), _unstable_at(margins, law, 10)]
    return law, tuple(each for each in found if each is not None)


def _loud(margins: Rows, law: str) -> Finding | None:
    """Return that a law comes close to ringing on fingers of the largest gain; None of one that bears them."""
    limits = {"sensitivity_peak_gain": MOST_PEAK, "sensitivity_peak_gain_low": MOST_PEAK_OFF}
    for name, limit in limits.items():
        peak = max((row.get(name, 0.0) for row in margins if row["law"] == law), default=0.0)
        if not peak <= limit:
            return Finding("LAW-LOUD", value=peak, limit=limit, more={"law": law})
    return None


def too_few(rows: Rows) -> Finding | None:
    """Return that a speed has too few capable fingers to decide anything; None where all have enough."""
    counts = {
        population: {row["speed_mm_s"]: row["fingers"] for row in rows if row["population"] == population}
        for population in ("all", "capable")
    }
    speed = min(counts["capable"], key=lambda each: counts["capable"][each])
    able, drawn = counts["capable"][speed], counts["all"][speed]
    if able >= ENOUGH:
        return None
    more = f"--fingers {10 * math.ceil(0.1 * ENOUGH * drawn / able)}" if able else ""
    where = Condition(speed_mm_s=speed)
    return Finding("COMPARE-FEW", value=able, limit=ENOUGH, where=where, remedy=more, more={"fingers": drawn})


def left_by(rows: Rows) -> dict[str, Left]:
    """Return what each law leaves, of capable fingers; without laws that are not to be taken."""
    found: dict[str, Left] = {}
    for row in rows:
        if row["population"] == "capable" and row["score"] == "residual_rms_n" and row["law"] not in NEVER:
            here = Left(row["worst_decile"], row["median"])
            found[row["law"]] = max(found.get(row["law"], here), here)
    return {law: left for law, left in found.items() if math.isfinite(left.worst_n)}


def _close(stable: Mapping[str, Left], law: str, best: str) -> Finding:
    """Return how another law differs from the recommended one, and how far fingers do."""
    other, apart = best if law == DEFAULT else DEFAULT, stable[DEFAULT].scatter_n
    value, limit = 1e3 * stable[other].worst_n, 1e3 * stable[law].worst_n
    return Finding("LAW-CLOSE", value=value, unit="mN", limit=limit, more={"law": other, "apart": 1e3 * apart})


def _rougher(rows: Rows, law: str, others: Iterable[str]) -> Iterator[Finding]:
    """Yield that touch feels clearly more of the error than under another law that is stable."""
    felt: dict[str, float] = {}
    for row in rows:
        touched = row["population"] == "capable" and row["score"] == "relative_index"
        if touched and row["law"] in (law, *others) and math.isfinite(row["median"]):
            felt[row["law"]] = max(felt.get(row["law"], 0.0), row["median"])
    calmest = min(felt, key=lambda each: felt[each], default=law)
    if calmest != law and law in felt and felt[law] >= ROUGHER * felt[calmest]:
        yield Finding("LAW-ROUGHER", value=felt[law], limit=felt[calmest], more={"law": calmest})


def _unstable_at(margins: Rows, law: str, percent: int) -> Finding | None:
    """Return where a law is not known to be stable with the resonance off by so much; None if it is everywhere."""
    rows: list[dict[str, Any]] = [row for row in margins if row["law"] == law]
    off = [row for row in rows if not math.isfinite(row[f"sensitivity_peak_{percent}"])]
    if rows and not off:
        return None
    speeds, lengths = (tuple(sorted({row[name] for row in off})) for name in ("speed_mm_s", "slip_length_um"))
    where = Condition(speed_mm_s=speeds or None, slip_length_um=lengths or None)
    return Finding("LAW-UNSTABLE", limit=percent, where=where, more={"law": law})
