"""The page of a study: who took part, what counted, psychometric functions, thresholds and sequences."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas  # type: ignore[import-untyped]
from jinja2 import Environment, PackageLoader

from frictionloop.experiments import folder
from frictionloop.experiments.kept_sessions import once_each, read_trials, sessions_in
from frictionloop.experiments.own_reach import reaches
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.summary import fits, funnel, groups, measure, pooled
from frictionloop.figures.style import inline, svg
from frictionloop.quantities import FrictionloopError, replacing
from frictionloop.report.experiment_figures import answers, converging, functions, sequences, thresholds


class Report(NamedTuple):
    """What sessions of one protocol have found."""

    protocol: Protocol
    about: str
    """How many sessions, and what their forces are of."""
    trials: pandas.DataFrame
    """Rows as in ``trials.tsv``."""
    fits: pandas.DataFrame
    """As `fits`."""
    groups: pandas.DataFrame
    """As `groups`."""
    pooled: pandas.DataFrame
    """As `pooled`."""
    funnel: pandas.DataFrame
    """As `funnel`."""
    reaches: pandas.DataFrame
    """As `reaches`."""


def report(path: str | os.PathLike[str], out: str | os.PathLike[str] | None = None) -> Report:
    """Fit what sessions of one protocol have found, and write it as a page.

    Parameters
    ----------
    path : path
        A session, or a folder of sessions.
    out : path, optional
        Page to write (.html), with its tables beside it.

    Raises
    ------
    FrictionloopError
        For a folder without sessions, sessions of different protocols or twice of one
        participant, or a page that cannot be written.
    """
    found = sessions_in(Path(path))
    once_each(found)
    protocol = folder.read(found[0])[0]
    for other in found[1:]:
        if folder.read(other)[0] != protocol:
            raise FrictionloopError(f"{other}: has another protocol than {found[0]}; report them apart")
    sources = {str(folder.read(each)[2]["source"]) for each in found}
    about = f"{len(found)} session{'s' * (len(found) > 1)}, {' and '.join(sorted(sources))}"
    report_ = study(protocol, read_trials(Path(path)), about, reaches(Path(path)))
    if out is not None:
        write_page(report_, Path(out))
    return report_


def study(
    protocol: Protocol, trials: pandas.DataFrame, about: str, of_fingers: pandas.DataFrame | None = None
) -> Report:
    """Return what trials have found.

    Parameters
    ----------
    protocol : Protocol
        What was asked.
    trials : pandas.DataFrame
        Rows as in ``trials.tsv``.
    about : str
        Where the trials are from, in words.
    of_fingers : pandas.DataFrame, optional
        As of `reaches`; none where it was not measured.
    """
    fitted = fits(protocol, trials)
    fingers = pandas.DataFrame() if of_fingers is None else of_fingers
    return Report(protocol, about, trials, fitted, groups(fitted), pooled(protocol, trials), funnel(trials), fingers)


def page(found: Report) -> str:
    """Return a study as one self-contained HTML page."""
    protocol, trials, fitted = found.protocol, found.trials, found.fits
    name, _ = measure(protocol)
    figures = {
        "thresholds": (thresholds(protocol, fitted), f"{name} by condition and participant"),
        "sequences": (sequences(protocol, trials), "Levels asked for over trials"),
    }
    if name in ("threshold", "JND"):
        figures["functions"] = (functions(protocol, trials, fitted), "Psychometric functions by condition")
        figures["convergence"] = (converging(protocol, trials), f"{name} and its interval from trial to trial")
    else:
        figures["answers"] = (answers(protocol, trials), "Answers over levels")
    drawn = {name: inline(svg(figure, name), label) for name, (figure, label) in figures.items()}
    shown = Environment(loader=PackageLoader("frictionloop.report"), autoescape=True, trim_blocks=True)
    shown.filters["number"] = number
    return shown.get_template("experiment.html.jinja").render(
        protocol=protocol,
        about=found.about,
        people=trials["participant"].nunique(),
        figures=drawn,
        groups=found.groups.to_dict("records"),
        fits=fitted.to_dict("records"),
        pooled=found.pooled.to_dict("records"),
        overdispersed=_overdispersed(fitted),
        reaches=found.reaches.to_dict("records"),
        funnel=_funnel_rows(trials),
        measure=measure(protocol),
        weber="weber" in fitted,
        at_edge=int(fitted["at_edge"].eq(True).sum()) if "at_edge" in fitted else 0,
        conditions=list(dict.fromkeys(trials["condition"])),
    )


def write_page(found: Report, path: Path) -> None:
    """Write the page of a study, and beside it its tables as TSV.

    Raises
    ------
    FrictionloopError
        For a file that cannot be written.
    """
    text = page(found)
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")
    for name in ("fits", "groups", "pooled", "funnel", "reaches"):
        table = getattr(found, name)
        if len(table.columns):
            with replacing(path.with_name(f"{path.stem}-{name}.tsv")) as beside:
                table.to_csv(beside, sep="\t", index=False, na_rep="n/a")


def write_figure(found: Report, path: Path) -> None:
    """Write the figure of what was found of each participant, as SVG, PDF or PNG by its name."""
    figure = thresholds(found.protocol, found.fits)
    with replacing(path) as beside:
        if path.suffix == ".svg":
            beside.write_text(svg(figure, "thresholds"), encoding="utf-8")
        else:
            figure.savefig(beside, format=path.suffix[1:], dpi=200)


def _overdispersed(fitted: pandas.DataFrame) -> tuple[int, int] | None:
    """Return how many functions have more dispersion than chance gives, and how many have any."""
    if "dispersion" not in fitted:
        return None
    known = fitted.dropna(subset=["dispersion"])
    return int((known["dispersion"] > known["dispersion_limit"]).sum()), len(known)


def number(value: Any) -> str:
    """Return a number for a person, three digits."""
    return "–" if value is None or not np.isfinite(value) else f"{value:.3g}"


def _funnel_rows(trials: pandas.DataFrame) -> list[tuple[str, list[int]]]:
    """Return what became of trials, a row for each fate and a number for each condition."""
    table = funnel(trials).pivot_table("trials", "what", "condition", fill_value=0, sort=False, aggfunc="sum")
    names = list(dict.fromkeys(trials["condition"]))
    order = sorted(
        table.index, key=lambda what: (what == "counted", what.startswith(("rep", "kept")), what != "presented")
    )
    return [(what, [int(table.loc[what, name]) for name in names]) for what in order]
