"""Why laws win or lose, as a person is shown it: laws side by side, a table for each speed and contact."""

from __future__ import annotations

import math
from typing import Any

from frictionloop.cli import screen

Rows = list[dict[str, Any]]
WHOLE = {"all": "all", "silent": "no disturbance", "left_over_costs": "only together"}
"""Parts that are of no one cause, as they are called here; `left_over_alone` is in the rows."""
LEGEND = (
    "costs: what a cause adds to all, sqrt(all² - without it²); below 0 more is left without it",
    "alone: what is left with that disturbance, or limit of the loop, and nothing else",
    "only together: what disturbances add beyond their costs, because they act on each other",
    "resonance: of the sensor's springs; misjudged: it is not where the controller believes it to be",
    "Hz: by frequency, of up to 20 fingers",
)
"""What the words of the tables mean."""


def why_summary(rows: Rows) -> list[Any]:
    """Return what is shown."""
    if not rows:
        return []
    laws = list(dict.fromkeys(row["law"] for row in rows))
    found: list[Any] = []
    for speed, contact in dict.fromkeys((row["speed_mm_s"], row["contact"]) for row in rows):
        some = [row for row in rows if (row["speed_mm_s"], row["contact"]) == (speed, contact)]
        found += ["", f"{speed:g} mm/s, {contact}: where the residual comes from, mN, median / worst decile"]
        found += [screen.table(_table(some, laws))]
    return [*found, "", *LEGEND, ""]


def _table(rows: Rows, laws: list[str]) -> list[tuple[str, ...]]:
    by = {(row["law"], row["part"]): row for row in rows}
    table = [("", *(word for law in laws for word in (f"{law}: costs", "alone")), "")]
    for part in dict.fromkeys(row["part"] for row in rows):
        if part == "left_over_alone":
            continue
        cells = [cell for law in laws for cell in _cells(by[law, part])]
        table.append((WHOLE.get(part, part), *cells, ""))
    return table


def _cells(row: dict[str, Any]) -> tuple[str, str]:
    if "cost_median" in row:
        return _both(row, "cost"), _milli(row["alone_median"])
    return _both(row, "rms"), ""


def _both(row: dict[str, Any], name: str) -> str:
    median, worst = _milli(row[f"{name}_median"]), _milli(row.get(f"{name}_worst_decile", math.nan))
    return median if worst == "-" else f"{median}/{worst}"


def _milli(value: float) -> str:
    """Return newtons as millinewtons, to a tenth below 10; - is none."""
    if math.isnan(value):
        return "-"
    milli = round(1e3 * value, 1) + 0.0  # what rounds to 0 has no sign
    return f"{milli:.0f}" if abs(milli) >= 10.0 or milli == 0.0 else f"{milli:.1f}"
