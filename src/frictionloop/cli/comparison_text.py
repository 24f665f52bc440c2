"""A comparison as a person is shown it: one table for each speed and contact, one of margins, and what is wrong."""

from __future__ import annotations

import math
from typing import Any

import xarray as xr

from frictionloop.cli import screen
from frictionloop.cli.comparison_advice import Rows, recommendation
from frictionloop.control.cost import BUDGET_CYCLES
from frictionloop.design.comparison import Comparison, value_of
from frictionloop.design.comparison.protocol import AMPLITUDE_N, LEVELS_N, STEP_LEVELS_N

SHOWN = (
    ("residual_rms_n", "sines, mN", 1e3),
    ("hold_rms_n", "holds, mN", 1e3),
    ("turn_peak_n", "turn, N", 1.0),
    ("fall_63_s", "fall, ms", 1e3),
    ("relative_index", "felt", 1.0),
)
"""Scores of the terminal's table, under short names; the rest is in --csv and --json."""
MARGINS = (
    ("sensitivity_peak", "Ms", 1.0),
    ("sensitivity_peak_5", "±5 %", 1.0),
    ("sensitivity_peak_10", "±10 %", 1.0),
    ("sensitivity_peak_gain", "2.7 x", 1.0),
    ("sensitivity_peak_gain_low", "-10 %", 1.0),
    ("phase_margin_deg", "phase", 1.0),
)
UNSTABLE_HAS_NONE = ("phase_margin_deg",)

LEAD = "phase: the least turn that makes the loop unstable, of lag; below 0 it is one of lead"
"""Of a phase margin: a stable loop may have a negative one."""
LEGEND = (
    "sines, holds: rms of the error at three levels; turn: largest force after a turn, at 0.6 N",
    "fall: time to 63 % of a step down; never, ∞, where ringing is there within the delay",
    "felt: how much of the error touch feels, over a stroke without control; below 1 it feels less",
    "Ms: largest gain on a disturbance",
    LEAD,
    "±5 %, ±10 %: Ms with the sensor's resonance off by that much, either way",
    "2.7 x, -10 %: Ms on a finger of 2.7 times the believed loop gain; with the resonance 10 % lower",
)
"""What the heads of the tables mean."""


def number(value: float, digits: int = 3) -> str:
    """Return a number as short as it says something; - is none, ∞ is beyond all measure."""
    if math.isnan(value):
        return "-"
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if 0.9 <= value < 1.0:
        return f"{value:.{digits}f}"
    return f"{value:.{digits}g}" if abs(value) < 1000 else f"{value:.0f}"


def short(value: float) -> str:
    """Return a score in two significant digits, whole from 10 on, so that a table of pairs fits 80 columns."""
    if math.isfinite(value) and abs(value) >= 9.95:
        return f"{value:.0f}"
    return number(value, 3).removeprefix("0") if 0.9 <= value < 1.0 else number(value, 2)


def summary(comparison: Comparison, scored: xr.Dataset, rows: Rows, margins: Rows) -> list[Any]:
    """Return what is shown."""
    levels = ", ".join(f"{each:g}" for each in LEVELS_N)
    said = (
        f"Forces of the protocol, not of the file: sines of {AMPLITUDE_N:g} N and holds at {levels} N, steps between "
        f"{STEP_LEVELS_N[0]:g} and {STEP_LEVELS_N[1]:g} N. `frictionloop sweep FILE --fingers 100` scores your own."
    )
    found: list[Any] = [screen.wrapped(said), ""]
    for v, speed in enumerate(comparison.speeds_mm_s):
        able = int(scored["capable"].values[v].sum())
        population = "capable" if able else "all"
        count = able or scored.sizes["finger"]
        for z in scored["slip_length_um"].values.tolist():
            told = f"{count} {population} fingers" if able else f"all {count} fingers, none of them capable"
            found += [f"{speed:g} mm/s, slip length {z:g} um: median / worst decile of {told}"]
            at = {"speed_mm_s": speed, "slip_length_um": z, "population": population}
            found += [screen.table(_scores(comparison, rows, at)), ""]
    found += ["median capable finger, worst of three levels, by linear analysis; - is not known;"]
    found += ["phase margin in degrees; tick: the worst whole one, of"]
    found += [f"{BUDGET_CYCLES} cycles at the firmware's 5 kHz, traced on the image in an emulator;"]
    found += ["- has no image, an unstable loop has no margins"]
    found += [screen.table(_margins(margins)), ""]
    found += LEGEND
    found += [screen.wrapped(f"note: {law} is left out: {reason}") for law, reason in comparison.left_out.items()]
    found += [f"version {comparison.cells.attrs['version']}", "", screen.wrapped(recommendation(rows, margins)), ""]
    return found


def _scores(comparison: Comparison, rows: Rows, at: dict[str, Any]) -> list[tuple[str, ...]]:
    heads = ("law", *(head for _, head, _ in SHOWN), "")
    table: list[tuple[str, ...]] = [heads]
    for law in comparison.laws:
        cells = []
        for score, _, factor in SHOWN:
            both = [factor * value_of(rows, key, law=law, score=score, **at) for key in ("median", "worst_decile")]
            cells.append("-" if math.isnan(both[0]) else "/".join(map(short, both)))
        table.append((law, *cells, ""))
    return table


def _margins(margins: Rows) -> list[tuple[str, ...]]:
    table: list[tuple[str, ...]] = [("law", "at", *(head for _, head, _ in MARGINS), "tick", "")]
    for row in margins:
        none = UNSTABLE_HAS_NONE if math.isinf(row["sensitivity_peak"]) else ()
        cells = ["-" if name in none else number(factor * row[name]) for name, _, factor in MARGINS]
        cost = "-" if row["tick_cycles_m4"] is None else str(row["tick_cycles_m4"])
        table.append((row["law"], f"{row['speed_mm_s']:g}, {row['slip_length_um']:g} um", *cells, cost, ""))
    return table
