"""The tables of control laws in pages/laws.md and docs/which-law.md, from what ``python -m studies.laws`` has left.

python -m studies.compared
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from studies.laws import CELL, KEYS

HERE = Path(__file__).parent
KEPT, PAGE = HERE / "results" / "laws.csv", HERE / "pages" / "laws.md"
CHOICE = HERE.parent / "docs" / "which-law.md"
MARKS = "<!-- python -m studies.compared -->", "<!-- end -->"
ERRORS = (
    ("residual_rms_n", "sines (mN)", 1e3),
    ("hold_rms_n", "holds (mN)", 1e3),
    ("turn_peak_n", "turn (N)", 1.0),
    ("relative_index", "felt", 1.0),
    ("over_oracle", "/ oracle", 1.0),
    ("fall_63_s", "fall to 63 % (ms)", 1e3),
)
"""Scores shown as median / worst decile, as far as they are kept."""
MARGINS = (
    ("sensitivity_peak", "$M_s$"),
    ("sensitivity_peak_5", "±5 %"),
    ("sensitivity_peak_10", "±10 %"),
    ("sensitivity_peak_gain", "2.7 x"),
    ("sensitivity_peak_gain_low", "2.7 x, -10 %"),
)
"""Margins of the median capable finger."""
WORST = (
    ("sensitivity_peak", "$M_s$", "median"),
    ("sensitivity_peak_10", "±10 %", "median"),
    ("sensitivity_peak_gain", "2.7 x", "median"),
    ("sensitivity_peak_gain_low", "2.7 x, -10 %", "median"),
)
CAPABLE, MEDIAN_FINGER = "capable", "median capable finger"
"""Populations shown."""
Row = dict[str, str]
Pairs = Sequence[tuple[str, str, float]]


def compared(kept: Path = KEPT) -> str:
    """Return tables of errors and margins for each speed."""
    rows = _read(kept)
    lengths = _names(rows, "slip_length_um")
    parts = []
    for speed in _names(rows, "speed_mm_s"):
        here = {c: [row for row in rows if row["speed_mm_s"] == speed and row["slip_length_um"] == c] for c in lengths}
        parts += [_table(f"**{float(speed):g} mm/s, slip length {c} um, errors**", here[c], ERRORS) for c in lengths]
        parts.append(_margins(f"**{float(speed):g} mm/s, margins**", here))
    return "\n\n".join(part for part in parts if part)


def _table(title: str, rows: list[Row], pairs: Pairs) -> str:
    rows = [row for row in rows if row["population"] == CAPABLE]
    pairs = [pair for pair in pairs if pair[0] in _names(rows, "score")]
    if not pairs:
        return ""
    count = max(int(row["fingers"]) for row in rows)
    heads = ("Law", *(head for _, head, _ in pairs))
    cells = _rows(heads, (_law(law, rows, pairs) for law in _names(rows, "law")))
    return f"{title}, median / worst decile of {count} capable fingers:\n\n{cells}"


def _margins(title: str, here: dict[str, list[Row]]) -> str:
    here = {c: [row for row in rows if row["population"] == MEDIAN_FINGER] for c, rows in here.items()}
    laws = list(dict.fromkeys(law for rows in here.values() for law in _names(rows, "law")))
    found = {
        law: [_number(_value(_scores(law, rows), name, "median")) for rows in here.values() for name, _ in MARGINS]
        for law in laws
    }
    first, *others = (head for _, head in MARGINS)
    heads = ("Law", *(head for contact in here for head in (f"{contact} um: {first}", *others)))
    known = ((f"`{law}`", *cells) for law, cells in found.items() if set(cells) != {"–"})
    return f"{title} of the median capable finger:\n\n{_rows(heads, known)}"


def _read(path: Path) -> list[Row]:
    """Return a row for each score of a cell that is kept."""
    found = []
    with path.open(newline="", encoding="utf-8") as stream:
        for cell in csv.DictReader(line for line in stream if not line.startswith("#")):
            place = {name: cell.pop(name) for name in CELL}
            for score in dict.fromkeys(name.split()[0] for name, value in cell.items() if value):
                found.append(place | {"score": score} | {key: cell[f"{score} {key}"] for key in KEYS})
    return found


def _names(rows: Iterable[Row], column: str) -> list[str]:
    return list(dict.fromkeys(row[column] for row in rows))


def _scores(law: str, rows: list[Row]) -> dict[str, Row]:
    return {row["score"]: row for row in rows if row["law"] == law}


def _law(law: str, rows: list[Row], pairs: Pairs) -> Iterable[Any]:
    at = _scores(law, rows)
    yield f"`{law}`"
    for name, _, factor in pairs:
        both = [_number(factor * _value(at, name, key)) for key in ("median", "worst_decile")]
        yield "–" if both == ["–", "–"] else " / ".join(both)


def _value(rows: dict[str, Row], name: str, key: str) -> float:
    return float(rows[name][key] or "nan") if name in rows else math.nan


def _number(value: float) -> str:
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞"
    return f"{value:.3f}" if 0.9 <= value < 1.0 else f"{value:,.0f}" if value >= 1000.0 else f"{value:.3g}"


def _rows(heads: Sequence[str], rows: Iterable[Iterable[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def choice(kept: Path = KEPT) -> str:
    """Return one line a law: errors by speed at the longer slip length, and the worst of all else."""
    rows = _read(kept)
    speeds, own = _names(rows, "speed_mm_s"), max(_names(rows, "slip_length_um"), key=float)
    heads = ("Law", *(f"{float(each):g} mm/s" for each in speeds), "turn (N)", "felt", *(head for _, head, _ in WORST))
    lines = []
    for law in _names(rows, "law"):
        here = [row for row in rows if row["law"] == law and row["population"] in (CAPABLE, MEDIAN_FINGER)]
        at = [
            {row["score"]: row for row in here if row["speed_mm_s"] == v and row["slip_length_um"] == own}
            for v in speeds
        ]
        cells = [_both(each) for each in at]
        for name, _, key in (("turn_peak_n", "", "median"), ("relative_index", "", "median"), *WORST):
            found = [float(row[key] or "nan") for row in here if row["score"] == name]
            cells.append(_number(max(found, default=math.nan)))
        lines.append((f"`{law}`", *cells))
    return _rows(heads, lines)


def _both(at: dict[str, Row]) -> str:
    """Return median and worst decile of sines, then of holds, in mN."""
    pairs = [[_number(1e3 * _value(at, name, key)) for key in KEYS] for name in ("residual_rms_n", "hold_rms_n")]
    return " / ".join(f"{median} ({worst})" for median, worst in pairs)


def written(page: str, table: str) -> str:
    """Return the page with a table between its marks."""
    (before, rest), end = page.split(MARKS[0]), MARKS[1]
    return f"{before}{MARKS[0]}\n\n{table}\n\n{end}{rest.split(end, 1)[1]}"


if __name__ == "__main__":
    for path, made in ((PAGE, compared()), (CHOICE, choice())):
        path.write_text(written(path.read_text(encoding="utf-8"), made), encoding="utf-8")
