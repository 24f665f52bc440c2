"""Which law a comparison recommends, and why: one that bears its device, the default unless another is better."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

Rows = list[dict[str, Any]]
DEFAULT = "notch_pi"
"""The law that is recommended unless another leaves less by more than fingers differ (docs/which-law.md)."""
NEVER = {"lookup", "printed_pi"}
"""Not recommended: no control, and gains for another device."""


ROUGHER = 1.3
"""Ratio of what touch feels under two laws from which it is told (chosen)."""
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


class Recommended(NamedTuple):
    """A law, or none, and the sentences that say why."""

    law: str | None
    why: tuple[str, ...]


def recommended(rows: Rows, margins: Rows) -> Recommended:
    """Return the law to take: of those stable with a resonance 5 % off, the default or one that is clearly better."""
    few = _too_few(rows)
    if few:
        return Recommended(None, few)
    left = _left(rows)
    stable = {law: each for law, each in left.items() if not _unstable(margins, law, "sensitivity_peak_5")}
    if not stable:
        return Recommended(None, ("None of these laws is known to stay stable with the sensor's resonance 5 % off.",))
    best = min(stable, key=lambda law: stable[law].worst_n)
    law, why = best, []
    if DEFAULT in stable:
        default = stable[DEFAULT]
        law = best if default.worst_n - stable[best].worst_n > default.scatter_n else DEFAULT
    why.append(f"It leaves {_mn(stable[law].worst_n)} in the worst decile of fingers, speeds and slip lengths.")
    if DEFAULT in stable and best != DEFAULT:
        other = best if law == DEFAULT else DEFAULT
        less = "less" if law == DEFAULT else "more"
        more = "no more than" if law == DEFAULT else "more than"
        why.append(f"{other} leaves {less}, {_mn(stable[other].worst_n)}.")
        why.append(f"That differs by {more} fingers do: {_mn(stable[DEFAULT].scatter_n)} from their median.")
    elif DEFAULT in left and DEFAULT not in stable:
        where = ", ".join(_unstable(margins, DEFAULT, "sensitivity_peak_5"))
        why.append(f"{DEFAULT} is not known to be stable with the resonance 5 % off: {where}.")
    why += _rougher(rows, law, [each for each in stable if each != law])
    off = _unstable(margins, law, "sensitivity_peak_10")
    if off:
        bearing = [each for each in stable if not _unstable(margins, each, "sensitivity_peak_10")]
        why.append(f"With the resonance 10 % off it is not stable everywhere: {', '.join(off)}.")
        why.append(f"Stable there: {' and '.join(bearing) or 'none of these laws'}.")
    return Recommended(law, tuple(why))


def recommendation(rows: Rows, margins: Rows) -> str:
    """Return what a person is told."""
    found = recommended(rows, margins)
    return f"Recommended: {found.law or 'none of these laws'}. {' '.join(found.why)}"


def _too_few(rows: Rows) -> tuple[str, ...]:
    """Return sentences where a speed has too few capable fingers to decide anything; none where all have enough."""
    counts = {
        population: {row["speed_mm_s"]: row["fingers"] for row in rows if row["population"] == population}
        for population in ("all", "capable")
    }
    speed = min(counts["capable"], key=lambda each: counts["capable"][each])
    able, drawn = counts["capable"][speed], counts["all"][speed]
    if able >= ENOUGH:
        return ()
    many = f" or --fingers {10 * math.ceil(0.1 * ENOUGH * drawn / able)}" if able else ""
    return (
        f"Of {drawn} fingers only {able} at {speed:g} mm/s can be given the forces of the comparison, and fewer than "
        f"{ENOUGH} decide nothing, neither for a law nor against it.",
        f"A larger plate.max_amplitude_um{many} gives more of them. Until then go by `frictionloop design controller`.",
    )


def _left(rows: Rows) -> dict[str, Left]:
    """Return what each law leaves, of capable fingers; without laws that are not to be taken."""
    found: dict[str, Left] = {}
    for row in rows:
        if row["population"] == "capable" and row["score"] == "residual_rms_n" and row["law"] not in NEVER:
            here = Left(row["worst_decile"], row["median"])
            found[row["law"]] = max(found.get(row["law"], here), here)
    return {law: left for law, left in found.items() if math.isfinite(left.worst_n)}


def _rougher(rows: Rows, law: str, others: list[str]) -> list[str]:
    """Return a sentence where touch feels clearly more of the error than under another law that is stable."""
    felt: dict[str, float] = {}
    for row in rows:
        touched = row["population"] == "capable" and row["score"] == "relative_index"
        if touched and row["law"] in (law, *others) and math.isfinite(row["median"]):
            felt[row["law"]] = max(felt.get(row["law"], 0.0), row["median"])
    calmest = min(felt, key=lambda each: felt[each], default=law)
    if calmest == law or law not in felt or felt[law] < ROUGHER * felt[calmest]:
        return []
    return [f"To touch it is rougher than {calmest}: felt is {felt[law]:.2g} and not {felt[calmest]:.2g}, so try both."]


def _unstable(margins: Rows, law: str, peak: str) -> list[str]:
    """Return the slip lengths and speeds at which a law is not known to be stable."""
    rows = [row for row in margins if row["law"] == law]
    if not rows:
        return ["no margins are known"]
    return [
        f"slip length {row['slip_length_um']:g} um at {row['speed_mm_s']:g} mm/s"
        for row in rows
        if not math.isfinite(row[peak])
    ]


def _mn(force_n: float) -> str:
    return f"{1e3 * force_n:.{1 if force_n < 0.01 else 0}f} mN"
