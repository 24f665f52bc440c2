"""``fl.reproduce``: the paper's figures and claims, all of them on a page, or some alone."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from frictionloop.figures.style import write_both
from frictionloop.findings import Result
from frictionloop.findings.result import frame
from frictionloop.loop.progress import progress_bar
from frictionloop.parameters import RETUNED, write_toml
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.code_version import cited_version
from frictionloop.report.claims import COUNTED, Claim, Statement, claim_ids, one_claim, others, statements, within
from frictionloop.report.closed_loop import Table
from frictionloop.report.gain_stability import asked_for
from frictionloop.report.number_text import with_unit
from frictionloop.report.page import build_report, prepare
from frictionloop.report.paper_figures import FIGURES
from frictionloop.report.results import Results, cited, command_of

if TYPE_CHECKING:
    import pandas as pd  # type: ignore[import-untyped]

UNITS = {"_n_rthz": ("uN/rtHz", 1e6), "_n": ("mN", 1e3), "_ms": ("ms", 1.0), "_hz": ("Hz", 1.0)}
"""What numbers are shown in, by the end of their names."""
HEADS = {
    "sensitivity_peak": "Ms",
    "sensitivity_peak_moist": "moist",
    "stable_from_n": "from mN",
    "spread_n": "spread",
    "error_n": "error",
    "r2_regression": "R2",
    "r2_identity": "R2 id.",
    "r2_bound": "bound",
}
PROTOCOLS: dict[str, Mapping[str, float]] = {"fig-5a": RETUNED, "fig-5a-printed": {}}
"""Figures whose bench and finger are saved beside them, and the gains there."""


class FigureMade(NamedTuple):
    """A figure that was written, and what it stands for."""

    name: str
    file: Path
    seeds: str
    version: str
    command: str
    """With version and seeds it is what the figure is cited by."""
    numbers: Table
    bench: Path | None
    """TOML file of the bench under the finger that is drawn, asked for all its forces; None of other figures."""

    def to_dict(self) -> dict[str, Any]:
        """Return it by name."""
        return self._asdict() | {"cite": " · ".join(cited(self.command, self.seeds))}


class Reproduction(Result, schema="reproduce/2"):
    """Statements and claims with their verdicts, and figures that were written."""

    folder: Path
    page: Path | None
    """None of figures and claims alone."""
    statements: tuple[Statement, ...] = ()
    """The eight that carry the paper; none of figures and claims alone."""
    claims: tuple[Claim, ...]
    figures: tuple[FigureMade, ...] = ()
    """Those that were asked for alone."""

    def rows(self) -> list[tuple[str, str]]:
        """Return the statements and where the page is; of claims alone each of them."""
        if self.page is not None:
            texts = (f"{each.verdict_text}: {each.title} ({each.number})" for each in self.statements)
            return [*((f"{k}", text) for k, text in enumerate(texts, 1)), ("page", str(self.page))]
        found = [row for claim in self.claims for row in _claim_rows(claim)]
        return found + [row for figure in self.figures for row in _figure_rows(figure)]

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return how many have each verdict, and claims with paper's and own value; of some alone their numbers."""
        if self.page is not None:
            judged: dict[str, Iterable[Claim | Statement]] = {
                "statements": self.statements,
                "their claims": within(self.statements),
                "others": others(self.claims),
            }
            counts = {
                name: [sum(each.verdict is word for each in of) for word in COUNTED] for name, of in judged.items()
            }
            rows = {each.id: (*each.paper_and_ours, each.accepts, each.verdict_text) for each in self.claims}
            table = frame(rows, "", ["paper", "here", "accepted", "verdict"])
            return {"verdicts": frame(counts, "", list(COUNTED)), "claims": table}
        found = {claim.id: _values(claim) for claim in self.claims}
        return found | {figure.name: _numbers(figure.numbers) for figure in self.figures if figure.numbers}


def _claim_rows(claim: Claim) -> Iterator[tuple[str, str]]:
    paper, ours = claim.paper_and_ours
    yield claim.id, f"{claim.verdict_text}: {claim.title} ({claim.place})"
    yield "paper", f"{paper}; here {ours}, {claim.quantity}; accepted {claim.accepts}"
    yield "cite", " · ".join(cited(claim.command, claim.seeds))


def _figure_rows(figure: FigureMade) -> Iterator[tuple[str, str]]:
    yield figure.name, str(figure.file)
    if figure.bench is not None:
        yield "bench", str(figure.bench)
    yield "cite", " · ".join(cited(figure.command, figure.seeds))


def _values(claim: Claim) -> pd.DataFrame:
    """Return each number of a claim, whether it is accepted, and whether it has a vote."""
    votes = dict.fromkeys(claim.readings, "reading") | dict.fromkeys(claim.assumed, "assumption")
    rows = {
        name: (with_unit(value, claim.unit, claim.digits), claim.holds[name], votes.get(name, "no vote"))
        for name, value in claim.all_values.items()
    }
    return frame(rows, "", ["value", "accepted", "as"])


def _numbers(numbers: Table) -> pd.DataFrame:
    """Return numbers in the units that people read, the heads short."""
    # The slope is left to JSON and Python.
    found = frame(numbers, "").astype(float).drop(columns=["slope"], errors="ignore")
    heads = {}
    for key in found.columns:
        end, (unit, factor) = next((each for each in UNITS.items() if key.endswith(each[0])), ("", ("", 1.0)))
        words = key.removesuffix(end).replace("_", " ")
        heads[key] = HEADS.get(key) or (f"{words}, {unit}" if unit else words)
        found[key] *= factor
    return found.rename(columns=heads)


def reproduce(
    folder: str | os.PathLike[str] = "report", only: Sequence[str] = (), *, progress: bool | None = None
) -> Reproduction:
    """Rebuild the paper's figures and claims: index.html, claims.json and figures (SVG, PNG) in a folder.

    Parameters
    ----------
    folder : path
        Where to write; made if it does not exist. Files of the same names are replaced, each once it is complete.
    only : sequence of str
        Names of figures and claims, such as "fig-5a" and "kp-optimum", which are made alone and without a page.
    progress : bool, optional
        Show a progress bar; by default on a terminal.

    Raises
    ------
    FrictionloopError
        The folder cannot be written, or a name is unknown; nothing has been computed then.
    """
    target = Path(folder)
    if not only:
        prepare(target)
        claims = build_report(target, progress)
        eight = tuple(statements(claims))
        return Reproduction(folder=target, page=target / "index.html", claims=tuple(claims), statements=eight)
    _check_names(only)
    wanted = [name for name in FIGURES if name in only]
    if wanted:
        prepare(target)
    # Only what is asked for counts on the bar, not the parts that it needs.
    with progress_bar("report", len(only), progress) as bar:
        results, figures = Results(bar.inner()), []
        for name in wanted:
            figures.append(_made(name, target / "figures", results))
            bar()
        some = tuple(one_claim(id, results) for id in only if id not in FIGURES)
    return Reproduction(folder=target, page=None, claims=some, figures=tuple(figures))


def _check_names(names: Iterable[str]) -> None:
    known = [*FIGURES, *claim_ids()]
    for name in names:
        if name not in known:
            near = difflib.get_close_matches(name, known, cutoff=0.4) or ["fig-5a", "kp-optimum"]
            said = f"only = {name!r}: is neither figure nor claim; near are {', '.join(near)}"
            raise FrictionloopError(said, "UNKNOWN-NAME")


def _made(name: str, folder: Path, results: Results) -> FigureMade:
    """Return a figure once it is written."""
    watched, path, bench = results.watched(), folder / f"{name}.svg", None
    figure = FIGURES[name].draw(watched)
    numbers, seeds, command = FIGURES[name].numbers(results), watched.seeds(), command_of(name)
    write_both(figure, name, path, " · ".join(cited(command, seeds)))
    if name in PROTOCOLS:
        bench = path.with_suffix(".toml")
        write_toml(asked_for(PROTOCOLS[name]), bench, said=[f"Bench and finger of {name}"])
    return FigureMade(name, path, seeds, cited_version(), command, numbers, bench)
