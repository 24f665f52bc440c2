"""Control laws compared on one bench, on fingers that none of them was tuned on, and which law to take."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import xarray as xr

from frictionloop.analysis.operating_point import RECORDED, at_levels
from frictionloop.design.comparison import trial_protocol
from frictionloop.design.comparison.comparison_run import LawRuns, run_laws
from frictionloop.design.comparison.comparison_scores import scores
from frictionloop.design.comparison.law_margins import Row, margin_rows, score_rows, tidy_rows
from frictionloop.design.comparison.trial_protocol import Entrant
from frictionloop.design.population_margins import MOST_PEAK
from frictionloop.findings import Condition, Finding, Result, shown
from frictionloop.findings.result import Figure, Table, Tables, frame, plain
from frictionloop.findings.result import Row as Line
from frictionloop.findings.shown import between
from frictionloop.loop.progress import progress_bar
from frictionloop.parameters import System
from frictionloop.quantities import check_known
from frictionloop.quantities.whole_files import only_writer

SHOWN = {
    "residual_rms_n": ("sines, mN", 1e3),
    "hold_rms_n": ("holds, mN", 1e3),
    "turn_peak_n": ("turn, N", 1.0),
    "fall_63_s": ("fall, ms", 1e3),
    "relative_index": ("felt", 1.0),
}
"""Scores of the tables, their heads and factors; `Comparison.scores` has all of them."""
MARGINS = {
    "sensitivity_peak": "Ms",
    "sensitivity_peak_5": "±5 %",
    "sensitivity_peak_10": "±10 %",
    "sensitivity_peak_gain": "2.7 x",
    "sensitivity_peak_gain_low": "2.7 x, -10 %",
    "phase_margin_deg": "phase, deg",
    "tick_instructions": "tick, instructions",
}
"""Margins of the table of them, and their heads; those of the first table are the first four."""
FIRST = 4


class Comparison(Result, schema="compare/1"):
    """How control laws do on one bench, and which to take."""

    runs: LawRuns
    scored: xr.Dataset
    """Scores over law, speed, slip length and finger (`scores`)."""
    scores: tuple[Row, ...]
    """Median and worst decile over fingers of each score, for each law, speed, slip length and population."""
    margins: tuple[Row, ...]
    """Of the median capable finger, the worst of three levels, for each law, speed and slip length."""
    recommended: str | None
    """The law to take; None if the comparison recommends none."""

    @property
    def population(self) -> str:
        """Whose scores are shown: capable fingers, or all where none is."""
        return "capable" if bool(self.scored["capable"].any()) else "all"

    def rows(self) -> list[Line]:
        """Return the law to take, what it leaves, on whom and at which forces."""
        law, ran = self.recommended, self.runs
        found = [("recommended", law or "none")]
        if law is not None:
            left = left_by(self.scores)[law]
            found.append(("leaves", f"{shown(1e3 * left.median_n)} mN rms, worst decile {shown(1e3 * left.worst_n)}"))
        able = ", ".join(str(int(each)) for each in self.scored["capable"].sum("finger").values)
        speeds = ", ".join(map(shown, ran.speeds_mm_s))
        found.append(("capable", f"{able} of {len(ran.people)} fingers at {speeds} mm/s"))
        levels, steps = ", ".join(map(shown, trial_protocol.LEVELS_N)), between(*trial_protocol.STEP_LEVELS_N, "N")
        return [*found, ("forces", f"sines and holds at {levels} N, steps {steps}")]

    def tables(self) -> Tables:
        """Return a line a law at its worst speed and slip length, and the scores and margins at each of them."""
        return {"laws": self._laws(), "scores": self._scores(), "margins": self._margins()}

    def _laws(self) -> Table:
        def worst(rows: Iterable[Row], name: str) -> float:
            values = [float(row[name]) for row in rows if row[name] is not None]
            return max((each for each in values if not math.isnan(each)), default=math.nan)

        found = {}
        for law in self.runs.laws:
            here = {name: self._of(law, name) for name in SHOWN}
            left = here["residual_rms_n"]
            row = {"sines, mN": 1e3 * worst(left, "median"), "worst, mN": 1e3 * worst(left, "worst_decile")}
            row |= {SHOWN[name][0]: worst(here[name], "median") for name in ("turn_peak_n", "relative_index")}
            margins = [row for row in self.margins if row["law"] == law]
            row |= {head: worst(margins, name) for name, head in list(MARGINS.items())[:FIRST]}
            found[law] = row
        return frame(found, "law")

    def _of(self, law: str, score: str) -> list[Row]:
        return [
            row for row in self.scores if (row["law"], row["score"], row["population"]) == (law, score, self.population)
        ]

    def _scores(self) -> Table:
        cells: dict[tuple[Any, ...], dict[str, Any]] = {}
        for law in self.runs.laws:
            for name, (head, factor) in SHOWN.items():
                for row in self._of(law, name):
                    at = {"mm/s": row["speed_mm_s"], "um": row["slip_length_um"]}
                    cell = cells.setdefault((law, *at.values()), {"law": law, **at})
                    cell |= {head: factor * row["median"], f"{head} worst": factor * row["worst_decile"]}
        return frame(list(cells.values()), "law")

    def _margins(self) -> Table:
        rows = [
            {"law": row["law"], "mm/s": row["speed_mm_s"], "um": row["slip_length_um"]}
            | {head: row[name] for name, head in MARGINS.items()}
            | ({"phase, deg": math.nan} if math.isinf(row["sensitivity_peak"]) else {})
            for row in self.margins
        ]
        return frame(rows, "law")

    def tidy(self) -> Table:
        """Return every score and margin, one row each."""
        import pandas as pd  # type: ignore[import-untyped]

        return pd.DataFrame(tidy_rows(list(self.scores), list(self.margins)))

    def figures(self) -> dict[str, Figure]:
        """Return all figures by name: residuals, and of each speed steps and sensitivity."""
        from frictionloop.design.comparison.law_figures import drawings

        return {name: draw() for name, draw in drawings(self.runs, self.scored).items()}

    def plot(self, name: str = "residuals") -> Figure:
        """Return a figure by name, as of `figures`."""
        from frictionloop.design.comparison.law_figures import drawings

        drawn = drawings(self.runs, self.scored)
        check_known("name", [name], drawn)
        return drawn[name]()

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name, and which fingers are capable at each speed."""
        ran, own = self.runs, {"schema": self.SCHEMA, "recommended": self.recommended}
        about: dict[str, Any] = {"system": ran.system, "laws": ran.laws, "left_out": ran.left_out}
        about |= {"seed": ran.seed, "fingers": len(ran.people), "speeds_mm_s": ran.speeds_mm_s}
        about |= {"duration_s": ran.duration_s, "score_from_s": ran.start_s}
        about["capable"] = {f"{v:g}": self.scored["capable"].sel(speed_mm_s=v).values for v in ran.speeds_mm_s}
        found = {**own, **about, "scores": self.scores, "margins": self.margins, "findings": self.findings}
        told: dict[str, Any] = plain(found)
        return told


def compare(
    system: System,
    laws: Iterable[str] | Mapping[str, Entrant] | None = None,
    count: int = 1000,
    seed: int = trial_protocol.EVALUATION_SEED,
    speeds_mm_s: Sequence[float] = trial_protocol.SPEEDS_MM_S,
    *,
    given: Collection[str] = (),
    **options: Any,
) -> Comparison:
    """Return how control laws do on a population of fingers that none was tuned on, and which law to take.

    Each law is designed as `fl.design.controller` does it.

    Parameters
    ----------
    system, laws, count, seed, speeds_mm_s
        As of `run_laws`. A recorded set-point counts by its levels in designs; the forces are those of the protocol.
    given
        Dotted names of values that somebody gave: those that the comparison sets itself are refused.
    options
        path, resume, n_jobs, progress, duration_s, start_s, begin: as of `run_laws`.

    Raises
    ------
    FrictionloopError
        As `run_laws`.
    ComparisonInterrupted
        On Ctrl-C; what is done is kept in ``path``.
    """
    trial_protocol.check_free(given)
    recorded = system.setpoint.kind in RECORDED
    bench = system.evolve({"setpoint": at_levels(system).setpoint}) if recorded else system
    with only_writer(options.get("path")):
        ran = run_laws(bench, laws, count, seed, speeds_mm_s, **options)
    scored = scores(ran)
    with progress_bar("margins of laws", len(ran.laws), options.get("progress")) as bar:
        rows, margins = score_rows(scored), margin_rows(ran, bar)
    law, why = recommended(rows, margins)
    out = [Finding("LAW-LEFT-OUT", more={"law": name, "reason": said}) for name, said in ran.left_out.items()]
    return Comparison(
        runs=ran,
        scored=scored,
        scores=tuple(rows),
        margins=tuple(margins),
        recommended=law,
        findings=(*why, *out, *([Finding("OWN-FORCES")] if recorded else [])),
    )


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
    why = loud = _loud(margins, DEFAULT) if DEFAULT in stable else None
    if loud is not None and (calm := {law: each for law, each in stable.items() if _loud(margins, law) is None}):
        law = min(calm, key=lambda name: calm[name].worst_n)
    else:
        law = best = min(stable, key=lambda law: stable[law].worst_n)
        why = rings.get(DEFAULT)
        if DEFAULT in stable and best != DEFAULT:
            default = stable[DEFAULT]
            law = best if default.worst_n - stable[best].worst_n > default.scatter_n else DEFAULT
            why = _close(stable, law, best)
    found = [why, *_rougher(rows, law, stable), _unstable_at(margins, law, 10)]
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


def _rougher(rows: Rows, law: str, stable: Collection[str]) -> Iterator[Finding]:
    """Yield that touch feels clearly more of the error than under another law that is stable."""
    felt: dict[str, float] = {}
    for row in rows:
        touched = row["population"] == "capable" and row["score"] == "relative_index"
        if touched and row["law"] in stable and math.isfinite(row["median"]):
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
