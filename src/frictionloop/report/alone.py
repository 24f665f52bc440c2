"""Some figures and claims alone, each with its numbers, also on a bench that is not the paper's."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from frictionloop.figures.style import write_both
from frictionloop.loop.progress import progress_bar
from frictionloop.parameters import write_toml
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.version import cited_version
from frictionloop.report import changed
from frictionloop.report.build import prepare
from frictionloop.report.changed_check import Check
from frictionloop.report.cited import cited, command_of
from frictionloop.report.claims import Claim, claim_ids, one_claim
from frictionloop.report.figure_numbers import NUMBERS
from frictionloop.report.figures import DRAWINGS
from frictionloop.report.results import Results
from frictionloop.report.stroke_numbers import Table

NOTHING = Check({}, [], {})
SAID = [
    "The bench and the finger of the figure beside this file, asked for all of its forces by one sine:",
    "margins are those of the figure, errors of its runs are not. Its gains are those given, or hold everywhere.",
    "For one level of the figure give both --setpoint.offset_n and --setpoint.amplitude_n.",
]
"""Begins the file of a changed bench."""


class Shown(NamedTuple):
    """A figure that was written, and what it stands for."""

    name: str
    file: Path
    seeds: str
    version: str
    command: str
    """With version and seeds it is what the figure is cited by."""
    changed: dict[str, Any]
    """What is not as on the paper's bench."""
    numbers: Table
    unchanged: Table
    """The same numbers of the bench that is not changed; empty where it is that."""
    alone: Table
    """With one change at a time, the numbers of its first gains; empty of a single change."""
    checked: Check
    """What ``design check`` says of the gains on a changed bench."""
    checked_before: Check
    """The same of the report's gains on the bench that is not changed."""
    bench: Path | None
    """The changed bench under the finger that is drawn; None of a figure that is not changed."""
    told: list[str]
    """What the numbers do not say of the change."""

    def as_dict(self) -> dict[str, Any]:
        """Return it by name, as JSON can hold it."""
        return self._asdict() | {each: getattr(self, each).as_dict() for each in ("checked", "checked_before")}


class Alone(NamedTuple):
    """What was asked for."""

    claims: list[Claim]
    figures: list[Shown]


def alone(
    folder: str | os.PathLike[str],
    names: Sequence[str],
    changes: Mapping[str, Any] | None = None,
    *,
    progress: bool | None = None,
) -> Alone:
    """Compute no more than some figures and claims need, and write the figures; no page.

    Parameters
    ----------
    folder : path
        Where to write; made if it does not exist and a figure is asked for.
    names : sequence of str
        Names of figures and claims, such as "fig-5a" and "kp-optimum".
    changes : mapping, optional
        What is to differ from the paper's bench, by dotted names: then the protocol's own figures of `changed.SHOWN`
        alone, which say so, and no claim.
    progress : bool, optional
        Show a progress bar; by default on a terminal.

    Raises
    ------
    FrictionloopError
        The folder cannot be written, a name is unknown, or the changes have no meaning for it; nothing has been
        computed then.
    """
    given = dict(changes or {})
    _check_names(names)
    if given:
        changed.check(names, given)
    target, wanted = Path(folder), [name for name in DRAWINGS if name in names]
    if wanted:
        prepare(target)
    # Only what is asked for counts on the bar, not the parts that it needs.
    with progress_bar("report", len(names), progress) as bar:
        results = Results(bar.inner())
        shown = []
        for name in wanted:
            if given:
                figure, numbers, before, single, checked, held, there, told = changed.drawn(name, given, bar.inner())
                file, seeds = changed.file_name(name, given), changed.seeds_of(given)
            else:
                watched = results.watched()
                figure, file = DRAWINGS[name](watched), name
                numbers, seeds = NUMBERS[name](results) if name in NUMBERS else {}, watched.seeds()
                before, single, checked, held, there, told = {}, {}, NOTHING, NOTHING, None, []
            path = target / "figures" / f"{file}.svg"
            write_both(figure, file, path, " · ".join(cited(command_of(name, given), seeds)))
            made = cited_version(), command_of(name, given)
            bench = None
            if there is not None:
                bench = path.with_suffix(".toml")
                write_toml(there, bench, said=SAID)
            shown.append(Shown(name, path, seeds, *made, given, numbers, before, single, checked, held, bench, told))
            bar()
        return Alone([one_claim(id, results) for id in names if id not in DRAWINGS], shown)


def _check_names(names: Iterable[str]) -> None:
    known = [*DRAWINGS, *claim_ids()]
    for name in names:
        if name not in known:
            raise FrictionloopError(
                f"only = {name!r}: is neither a figure nor a claim; a name is accepted, as "
                f"{' or '.join(_near(name, known)) or 'fig-5a or closed-loop-r2'}; the page of the report names each"
            )


def _near(name: str, known: Sequence[str]) -> list[str]:
    """Return up to three names that have a word of this one, else names that are written much as it is."""
    parts = {each for each in name.split("-") if len(each) > 2}
    shared = {each: len(parts & set(each.split("-"))) for each in known}
    with_words = sorted((each for each in known if shared[each]), key=lambda each: -shared[each])
    written = difflib.get_close_matches(name, known, cutoff=0.6)
    return list(dict.fromkeys([*written, *with_words]))[:3] or difflib.get_close_matches(name, known, cutoff=0.4)
