"""Control laws compared on one bench, on fingers that none of them was tuned on."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import xarray as xr

from frictionloop.analysis.levels import RECORDED, at_levels
from frictionloop.design.comparison import trial_protocol
from frictionloop.design.comparison.entrants import Entrant
from frictionloop.design.comparison.law_margins import Row, margin_rows, score_rows, tidy_rows
from frictionloop.design.comparison.recommendation import left_by, recommended
from frictionloop.design.comparison.run import LawRuns, run_laws
from frictionloop.design.comparison.scores import scores
from frictionloop.findings import Finding, Result, shown
from frictionloop.findings.result import Row as Line
from frictionloop.findings.result import frame, plain
from frictionloop.findings.shown import between
from frictionloop.loop.progress import progress_bar
from frictionloop.parameters import System
from frictionloop.quantities import check_known
from frictionloop.quantities.whole_files import only_writer

if TYPE_CHECKING:
    import pandas as pd  # type: ignore[import-untyped]
    from matplotlib.figure import Figure

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


@dataclass(frozen=True, kw_only=True)
class Comparison(Result):
    """How control laws do on one bench, and which to take."""

    SCHEMA: ClassVar[str] = "compare/1"
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
        levels, steps = (
            ", ".join(map(shown, trial_protocol.LEVELS_N)),
            between(*trial_protocol.STEP_LEVELS_N, "N"),
        )
        return [*found, ("forces", f"sines and holds at {levels} N, steps {steps}")]

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return a line a law at its worst speed and slip length, and the scores and margins at each of them."""
        return {"laws": self._laws(), "scores": self._scores(), "margins": self._margins()}

    def _laws(self) -> pd.DataFrame:
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

    def _scores(self) -> pd.DataFrame:
        cells: dict[tuple[Any, ...], dict[str, Any]] = {}
        for law in self.runs.laws:
            for name, (head, factor) in SHOWN.items():
                for row in self._of(law, name):
                    at = {"mm/s": row["speed_mm_s"], "um": row["slip_length_um"]}
                    cell = cells.setdefault((law, *at.values()), {"law": law, **at})
                    cell |= {head: factor * row["median"], f"{head} worst": factor * row["worst_decile"]}
        return frame(list(cells.values()), "law")

    def _margins(self) -> pd.DataFrame:
        rows = [
            {"law": row["law"], "mm/s": row["speed_mm_s"], "um": row["slip_length_um"]}
            | {head: row[name] for name, head in MARGINS.items()}
            | ({"phase, deg": math.nan} if math.isinf(row["sensitivity_peak"]) else {})
            for row in self.margins
        ]
        return frame(rows, "law")

    def tidy(self) -> pd.DataFrame:
        """Return every score and margin, one row each."""
        import pandas as pd

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
