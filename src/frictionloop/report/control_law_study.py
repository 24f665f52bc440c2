"""Beyond the paper: control laws on a small population of fingers, as a stored study has found them.

The report runs no law here: ``python -m studies.beyond`` does, and writes the two files in ``report/stored``.
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.design.comparison import trial_protocol
from frictionloop.report.number_text import number
from frictionloop.report.paper_protocol import LEVELS_N, OPEN, PRINTED, RETUNED_GAINS

COMMAND = "python -m studies.beyond"
SPEED_MM_S = 20.0
"""Speed of the strokes (paper, Sec. 4.2)."""
SHOWN_MS = {"down": (-5.0, 60.0), "up": (-5.0, 60.0)}
"""What is shown of them: how long a law takes to be at rest."""
FOLDER = files("frictionloop.report") / "stored"
SUMMARY, STEPS = "beyond.json", "beyond-steps.csv"
NOTCH, ORACLE = "notch and feed-forward", trial_protocol.ORACLE
LAWS = (OPEN, PRINTED, RETUNED_GAINS, NOTCH, ORACLE)
"""Who competes, named as in Fig. 5."""
MEDIAN, WORST = "median", "worst_decile"


@dataclass(frozen=True)
class Beyond:
    """What the study has found at 20 mm/s (paper, Sec. 4.2)."""

    version: str
    """Of the package that ran it."""
    seed: int
    slip_lengths_um: tuple[float, ...]
    scored: xr.Dataset
    """``residual_rms_n`` (N) over law, speed_mm_s, slip_length_um and finger, and which fingers are ``capable``."""
    cells: Mapping[tuple[str, float], Mapping[str, Any]]
    """By law and slip length: ``scores`` of the capable fingers, and what is told of the median one of them.

    ``sensitivity_peak`` is Ms around 0.6 N, ``sensitivity_peak_10`` the worst with the resonance 10 % off,
    ``median_finger_rms_n`` what is left on the sines.
    """
    tick_instructions: Mapping[str, int | None]
    """Instructions of the worst tick on a Teensy 4.1, by law."""
    limit_n: Mapping[float, float]
    """Bound on the residual of any linear controller of force and load with Ms at most 2 there, by slip length."""
    steps: xr.Dataset
    """``f_r`` and ``f_a`` (N) of that finger around a step down and one up, over law, slip length and time."""

    @property
    def able(self) -> list[bool]:
        """Which of the fingers are capable."""
        found: list[bool] = self.scored["capable"].values[0].tolist()
        return found

    def value(self, law: str, length_um: float, score: str, key: str = MEDIAN) -> float:
        """Return one number of the capable fingers: the median of a score, or its worst decile."""
        return float(self.cells[law, length_um]["scores"][score][(MEDIAN, WORST).index(key)])


@cache
def stored() -> Beyond:
    """Return the study that comes with the package."""
    found = json.loads((FOLDER / SUMMARY).read_text(encoding="utf-8"))
    laws, lengths = list(found["laws"]), list(found["limit_n"])
    residual = np.array([[found["laws"][law][z]["residual_rms_n"] for z in lengths] for law in laws])
    return Beyond(
        version=found["version"],
        seed=found["seed"],
        slip_lengths_um=tuple(map(float, lengths)),
        scored=xr.Dataset(
            {
                "residual_rms_n": (("law", "speed_mm_s", "slip_length_um", "finger"), residual[:, None]),
                "capable": (("speed_mm_s", "finger"), np.array([found["capable"]])),
            },
            {"law": laws, "speed_mm_s": [found["speed_mm_s"]], "slip_length_um": list(map(float, lengths))},
        ),
        cells={(law, float(z)): found["laws"][law][z] for law in laws for z in lengths},
        tick_instructions={law: found["laws"][law]["tick_instructions"] for law in laws},
        limit_n={float(z): limit for z, limit in found["limit_n"].items()},
        steps=_steps(),
    )


def _steps() -> xr.Dataset:
    heads, *rows = csv.reader((FOLDER / STEPS).read_text(encoding="utf-8").splitlines())
    columns = dict(zip(heads, np.array(rows, dtype=float).T, strict=True))
    laws, lengths = (
        list(dict.fromkeys(names)) for names in zip(*(head.split(", ") for head in heads[2:]), strict=True)
    )
    forces = np.array([[columns[f"{law}, {z}"] for z in lengths] for law in laws])
    over = ("law", "slip_length_um", "time")
    return xr.Dataset(
        {"f_r": (over, np.broadcast_to(columns["f_r"], forces.shape)), "f_a": (over, forces)},
        {"law": laws, "slip_length_um": list(map(float, lengths)), "time": columns["time_s"]},
    )


def beyond_rows(found: Beyond) -> list[dict[str, str]]:
    """Return a row of texts for each law and slip length."""
    return [_row(found, law, z) for law, z in found.cells]


def _row(found: Beyond, law: str, length_um: float) -> dict[str, str]:
    def both(score: str) -> str:
        return " / ".join(_plain(1e3 * found.value(law, length_um, score, key), 2) for key in (MEDIAN, WORST))

    cell, tick = found.cells[law, length_um], found.tick_instructions[law]
    levels = [found.value(law, length_um, f"r2_identity_{level:g}_n") for level in LEVELS_N]
    fall, rise = (
        "–" if law == OPEN else _ms(found.value(law, length_um, score))  # whose force goes elsewhere
        for score in ("fall_10_90_s", "rise_10_90_s")
    )
    return {
        "law": law,
        "length": f"{length_um:g}",
        "sines": both("residual_rms_n"),
        "hold": both("hold_rms_n"),
        "r2": _r2(found.value(law, length_um, "r2_identity")),
        "levels": " ".join(_r2(level) for level in levels),
        "fall": fall,
        "rise": rise,
        "felt": _plain(found.value(law, length_um, "relative_index"), 2),
        "peak": _plain(float(cell["sensitivity_peak"]), 2),
        "peak_10": _plain(float(cell["sensitivity_peak_10"]), 2),
        "tick": "–" if tick is None else f"{tick:,}",
        "oracle": "1" if law == ORACLE else _plain(found.value(law, length_um, "over_oracle"), 2),
    }


def _plain(value: float, digits: int) -> str:
    if math.isnan(value):
        return "–"
    return "unstable" if math.isinf(value) else number(value, digits)


def _ms(value_s: float) -> str:
    return "never" if not math.isfinite(value_s) else number(1e3 * value_s, 2)


def _r2(value: float) -> str:
    return f"{value:.3f}" if value >= 0.0 else "< 0"
