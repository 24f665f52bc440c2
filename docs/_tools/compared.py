"""The table of control laws, from scores that `frictionloop compare` has left beside the pages.

``python docs/_tools/compared.py tournament/scores.csv`` keeps the few that the table shows.
"""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tables import table

KEPT = Path(__file__).parents[1] / "_static" / "tournament.csv"
MISSING = (
    "*No scores are stored with these pages yet. `make tournament` makes them (`tournament/scores.csv`), and "
    "`python docs/_tools/compared.py tournament/scores.csv` puts what this table shows beside them.*"
)
PAIRS = (
    ("residual_rms_n", "rms (mN)", 1e3),
    ("hold_rms_n", "hold (mN)", 1e3),
    ("r2_identity", "$R^2$", 1.0),
    ("fall_63_s", "fall to 63 % (ms)", 1e3),
    ("fall_63_over_bound", "fall / shortest", 1.0),
    ("rise_10_90_over_limit", "rise / skin's", 1.0),
    ("rise_10_90_over_bound", "rise / shortest", 1.0),
    ("relative_index", "felt", 1.0),
    ("over_oracle", "/ oracle", 1.0),
)
"""Scores shown as median / worst decile of the capable fingers, as far as they are kept."""
SINGLE = (
    ("sensitivity_peak", "$M_s$"),
    ("sensitivity_peak_5", "±5 %"),
    ("sensitivity_peak_10", "±10 %"),
    ("sensitivity_peak_learnt", "learnt"),
)
"""Margins of the median capable finger."""
POPULATIONS = "capable", "median capable finger"
SHOWN = {name for name, *_ in (*PAIRS, *SINGLE)}
Row = dict[str, str]


def compared(kept: Path = KEPT) -> str:
    """Return a table for each speed and contact, or the line that says how to get them."""
    if not kept.exists():
        return MISSING
    rows = _read(kept)
    parts = []
    for speed in _names(rows, "speed_mm_s"):
        for contact in _names(rows, "contact"):
            here = [row for row in rows if row["speed_mm_s"] == speed and row["contact"] == contact]
            count = max((int(row["fingers"]) for row in here), default=0)
            title = f"**{float(speed):g} mm/s, {contact}**, median / worst decile of {count} capable fingers"
            pairs = [pair for pair in PAIRS if pair[0] in _names(here, "score")]
            heads = ("Law", *(head for _, head, _ in pairs), *(head for _, head in SINGLE))
            parts.append(f"{title}:\n\n" + table(heads, (_law(law, here, pairs) for law in _names(here, "law"))))
    return "\n\n".join(parts)


def keep(scores: Path, kept: Path = KEPT) -> None:
    """Copy what the table shows out of a tournament's scores, at four digits."""
    rows = [row for row in _read(scores) if row["score"] in SHOWN and row["population"] in POPULATIONS]
    for row in rows:
        row |= {key: f"{float(row[key] or 'nan'):.4g}" for key in ("median", "worst_decile")}
    with kept.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def _read(path: Path) -> list[Row]:
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def _names(rows: Iterable[Row], column: str) -> list[str]:
    return list(dict.fromkeys(row[column] for row in rows))


def _law(law: str, rows: list[Row], pairs: Iterable[tuple[str, str, float]]) -> Iterable[Any]:
    at = {row["score"]: row for row in rows if row["law"] == law and row["population"] in POPULATIONS}
    yield f"`{law}`"
    for name, _, factor in pairs:
        both = [_number(factor * _value(at, name, key)) for key in ("median", "worst_decile")]
        yield "–" if both == ["–", "–"] else " / ".join(both)
    for name, _ in SINGLE:
        yield _number(_value(at, name, "median"))


def _value(rows: dict[str, Row], name: str, key: str) -> float:
    return float(rows[name][key] or "nan") if name in rows else math.nan


def _number(value: float) -> str:
    if math.isnan(value):
        return "–"
    return "∞" if math.isinf(value) else f"{value:.3f}" if 0.9 <= value < 1.0 else f"{value:.3g}"


if __name__ == "__main__":
    keep(Path(sys.argv[1]))
