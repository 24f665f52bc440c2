"""The numbers of "Beyond the paper" as the page shows them."""

from __future__ import annotations

import math

import numpy as np

from frictionloop.design.tournament import EVALUATION_SEED, protocol
from frictionloop.report.beyond import MEDIAN, ORACLE, SPEED_MM_S, WORST, Race
from frictionloop.report.numbers import number

SHORT = {
    "printed gains": "printed",
    "re-tuned gains": "retuned",
    "notch and feed-forward": "notch",
    "tracker (experimental)": "tracker",
    "open loop": "open",
}
"""What the facts call laws, where their name is longer."""


def beyond_rows(race: Race) -> list[dict[str, str]]:
    """Return a row of texts for each law and contact."""
    return [_row(race, law, contact) for law in race.scored["law"].values.tolist() for contact in protocol.CONTACTS]


def beyond_facts(race: Race) -> dict[str, str]:
    """Return the numbers that the section's text quotes."""
    able = race.scored["capable"].sel(speed_mm_s=SPEED_MM_S)
    found = {
        "beyond people": str(able.size),
        "beyond capable": str(int(able.sum())),
        "beyond seed": str(EVALUATION_SEED),
    }
    for law in race.limit_of:
        for contact in protocol.CONTACTS:
            at = f"beyond {SHORT.get(law, law)} {contact}"
            found |= {
                at: _mn(race.value(law, contact, "residual_rms_n")),
                f"{at} worst": _mn(race.value(law, contact, "residual_rms_n", WORST)),
                f"{at} fall": _ms(race.value(law, contact, "fall_10_90_s")),
                f"{at} after": _mn(after_fall_n(race, law, contact)),
                f"{at} median finger": _mn(race.limit_of[law][contact]),
            }
    return found | {f"beyond limit {contact}": _mn(limit) for contact, limit in race.limit_n.items()}


def after_fall_n(race: Race, law: str, contact: str) -> float:
    """Return the rms of f_a - f_r from 5 to 60 ms after the step down, on the median finger, N."""
    some = race.traces.sel(law=law, contact=contact, time=slice(1.005, 1.06))
    return float(np.sqrt(np.mean((some["f_a"].values - some["f_r"].values) ** 2)))


def _row(race: Race, law: str, contact: str) -> dict[str, str]:
    def both(score: str) -> str:
        return " / ".join(_mn(race.value(law, contact, score, key)) for key in (MEDIAN, WORST))

    peak, peak_10 = race.peaks[law, contact]
    worst = race.tick[law]
    levels = [race.value(law, contact, f"r2_identity_{level:g}_n") for level in protocol.LEVELS_N]
    return {
        "law": law,
        "contact": contact,
        "sines": both("residual_rms_n"),
        "hold": both("hold_rms_n"),
        "r2": _r2(race.value(law, contact, "r2_identity")),
        "levels": " ".join(_r2(level) for level in levels),
        "fall": _ms(race.value(law, contact, "fall_10_90_s")),
        "rise": _ms(race.value(law, contact, "rise_10_90_s")),
        "felt": _plain(race.value(law, contact, "relative_index"), 2),
        "peak": _plain(peak, 2),
        "peak_10": _plain(peak_10, 2),
        "tick": f"{worst.cycles:,}" if worst else "–",
        "oracle": "1" if law == ORACLE else _plain(race.value(law, contact, "over_oracle"), 2),
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
