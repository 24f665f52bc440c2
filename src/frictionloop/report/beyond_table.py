"""The numbers of "Beyond the paper" as the page shows them."""

from __future__ import annotations

import math

from frictionloop.report.beyond import MEDIAN, ORACLE, WORST, Beyond
from frictionloop.report.numbers import number
from frictionloop.report.protocol import LEVELS_N


def beyond_rows(found: Beyond) -> list[dict[str, str]]:
    """Return a row of texts for each law and contact."""
    return [_row(found, law, contact) for law, contact in found.cells]


def _row(found: Beyond, law: str, contact: str) -> dict[str, str]:
    def both(score: str) -> str:
        return " / ".join(_mn(found.value(law, contact, score, key)) for key in (MEDIAN, WORST))

    cell, cycles = found.cells[law, contact], found.tick_cycles[law]
    levels = [found.value(law, contact, f"r2_identity_{level:g}_n") for level in LEVELS_N]
    return {
        "law": law,
        "contact": contact,
        "sines": both("residual_rms_n"),
        "hold": both("hold_rms_n"),
        "r2": _r2(found.value(law, contact, "r2_identity")),
        "levels": " ".join(_r2(level) for level in levels),
        "fall": _ms(found.value(law, contact, "fall_10_90_s")),
        "rise": _ms(found.value(law, contact, "rise_10_90_s")),
        "felt": _plain(found.value(law, contact, "relative_index"), 2),
        "peak": _plain(float(cell["sensitivity_peak"]), 2),
        "peak_10": _plain(float(cell["sensitivity_peak_10"]), 2),
        "tick": "–" if cycles is None else f"{cycles:,}",
        "oracle": "1" if law == ORACLE else _plain(found.value(law, contact, "over_oracle"), 2),
    }


def _plain(value: float, digits: int) -> str:
    if math.isnan(value):
        return "–"
    return "unstable" if math.isinf(value) else number(value, digits)


def _mn(value_n: float) -> str:
    return _plain(1e3 * value_n, 2)


def _ms(value_s: float) -> str:
    return "never" if not math.isfinite(value_s) else number(1e3 * value_s, 2)


def _r2(value: float) -> str:
    return f"{value:.3f}" if value >= 0.0 else "< 0"
