"""Beyond the paper: control laws on a small population of fingers that none of them was tuned on."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from joblib import Parallel, delayed

from frictionloop.control.cost import WorstTick, worst_tick
from frictionloop.design import tournament as rooms
from frictionloop.design.linear_reach import linear_reach_table
from frictionloop.design.tournament import margins, protocol
from frictionloop.design.tournament.entrants import ENTRANTS, Entrant, Overrides
from frictionloop.design.tournament.measured import on_device
from frictionloop.design.tournament.traces import LEVEL_N, step_traces
from frictionloop.parameters import bench
from frictionloop.report.device import OPEN, PRINTED, RETUNED_GAINS

SPEED_MM_S = 20.0
"""Speed of the strokes (paper, Sec. 4.2)."""
NOTCH, TRACKER, ORACLE = "notch and feed-forward", "tracker (experimental)", "oracle"
MEDIAN, WORST = "median", "worst_decile"
PEAK = 2.0
"""Largest |S| that the computed limit allows."""
NOTCH_DESIGNED: Overrides = {
    "controller.kind": "notch_pi",
    "controller.kp": 6.36,
    "controller.ki": 52.1,
    "controller.notch_hz": 136.7,
    "controller.notch_depth": 0.00151,
    "controller.notch_width": 10.0,
    "controller.feedforward": True,
    "controller.overdrive": True,
}
"""What `design_controller(bench(), "notch_pi")` finds, as the tournament asks anew: that takes longer than a page.

The gains are named: a change of kind alone keeps the printed ones, with which the notch is unstable.
"""
LAWS: dict[str, Entrant] = {
    OPEN: ENTRANTS["lookup"],
    PRINTED: ENTRANTS["printed_pi"],
    RETUNED_GAINS: ENTRANTS["retuned_pi"],
    NOTCH: lambda system: NOTCH_DESIGNED,
    TRACKER: ENTRANTS["tracker"],
    ORACLE: ENTRANTS["oracle"],
}
"""Who competes, named as in Fig. 5."""
HALVES = ((OPEN, PRINTED, RETUNED_GAINS, NOTCH), (TRACKER, ORACLE))
"""Laws that run side by side: so few fingers keep one core busy."""


@dataclass(frozen=True)
class Race:
    """What the small tournament found."""

    scored: xr.Dataset
    """Every score over law, speed_mm_s, contact and finger (`tournament.scores`)."""
    rows: list[dict[str, Any]]
    """Medians and worst deciles (`tournament.score_rows`)."""
    peaks: dict[tuple[str, str], tuple[float, float]]
    """Ms by law and contact on the median capable finger around 0.6 N: nominal, worst 10 % off."""
    tick: dict[str, WorstTick | None]
    """Worst tick of each law on a Cortex-M4; None of what has no image."""
    traces: xr.Dataset
    """Steps of that finger."""
    limit_n: dict[str, float]
    """Bound on the residual of any linear controller of force and load with Ms at most 2 on that finger, by contact."""
    limit_of: dict[str, dict[str, float]]
    """What each law leaves on that finger on the sines, N, by contact."""

    def value(self, law: str, contact: str, score: str, key: str = MEDIAN) -> float:
        """Return one number of the capable fingers."""
        return value_of(self.rows, law, contact, score, key)


def compared(laws: Iterable[str]) -> rooms.Tournament:
    """Return some of the laws through the protocol at 20 mm/s."""
    some = {name: LAWS[name] for name in laws}
    return rooms.compare(bench(), rooms.SMALL, laws=some, speeds_mm_s=[SPEED_MM_S], n_jobs=1, progress=False)


def race() -> Race:
    """Run all laws, score them, and compute what bounds them."""
    halves = Parallel(n_jobs=len(HALVES), prefer="threads")(delayed(compared)(names) for names in HALVES)
    whole = _joined(halves)
    scored = rooms.scores(whole)
    number, finger = _median(whole, scored)
    stroked = whole.system.evolve({"motion.stroke_mm": protocol.STROKE_MM})
    limits = linear_reach_table(stroked, [finger], [SPEED_MM_S], peaks=[PEAK])["bound_rms_n"]
    of_both = limits.sel(measured="force and load", speed_mm_s=SPEED_MM_S, sensitivity_peak=PEAK, drop=True)
    own = scored["residual_rms_n"].sel(speed_mm_s=SPEED_MM_S).isel(finger=number)
    return Race(
        scored,
        rooms.score_rows(scored),
        {(law, at): _peaks(whole, law, at) for law in whole.laws for at in protocol.CONTACTS},
        {law: worst_tick(whole.system.evolve(overrides).controller.kind) for law, overrides in whole.laws.items()},
        step_traces(whole, SPEED_MM_S),
        {contact: float(of_both.sel(contact=contact).item()) for contact in protocol.CONTACTS},
        {name: {at: float(own.sel(law=name, contact=at)) for at in protocol.CONTACTS} for name in whole.laws},
    )


def value_of(rows: list[dict[str, Any]], law: str, contact: str, score: str, key: str = MEDIAN) -> float:
    """Return the median of a score over the capable fingers, or its worst decile."""
    return rooms.value_of(rows, key, law=law, contact=contact, population="capable", score=score)


def rms_ratio(of: str, over: str, contact: str, score: str) -> float:
    """Return the median of a residual under one law over that under another, on the capable fingers."""
    rows = rooms.score_rows(rooms.scores(compared((of, over))))
    return value_of(rows, of, contact, score) / value_of(rows, over, contact, score)


def _joined(halves: list[rooms.Tournament]) -> rooms.Tournament:
    """Return one tournament of the laws of several; each has the plain strokes, the same in all."""
    laws = {name: overrides for half in halves for name, overrides in half.laws.items()}
    cells = [halves[0].cells, *(half.cells.sel(law=list(half.laws)) for half in halves[1:])]
    return replace(halves[0], laws=laws, cells=xr.concat(cells, "law"))


def _median(whole: rooms.Tournament, scored: xr.Dataset) -> tuple[int, Mapping[str, Any]]:
    """Return number and overrides of the median capable finger."""
    some = np.asarray(scored["capable"].sel(speed_mm_s=SPEED_MM_S).values)
    finger = protocol.median_finger(whole.people, some)
    return next(i for i, each in enumerate(whole.people) if each is finger), finger or {}


def _peaks(whole: rooms.Tournament, law: str, contact: str) -> tuple[float, float]:
    """Return Ms with the resonance as the bench says, and the worst of that and of 10 % off; NaN without a loop."""
    system = margins.median_system(whole, law, SPEED_MM_S, contact)
    if system is None:
        return math.nan, math.nan
    shifted = (on_device(system, factor) for factor in (1.0, 0.9, 1.1))
    loops = [margins.loop_at(each, LEVEL_N, whole.middle_s) for each in shifted]
    found = [math.nan if loop is None else loop.margins().sensitivity_peak for loop in loops]
    return found[0], max(found)
