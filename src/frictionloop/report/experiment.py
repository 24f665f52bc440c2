"""The page of a study: who took part, what counted, psychometric functions, thresholds and sequences."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas  # type: ignore[import-untyped]
from jinja2 import Environment, PackageLoader
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from frictionloop.experiments import folder
from frictionloop.experiments.convergence import convergence
from frictionloop.experiments.fit import grouped
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.psychometric import probability
from frictionloop.experiments.summary import (
    fits,
    funnel,
    groups,
    measure,
    pooled,
    reaches,
    read_trials,
    sessions_in,
)
from frictionloop.quantities import FrictionloopError, replacing
from frictionloop.report.style import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION, inline, new_figure, styled, svg

COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, GREY)
LINES = ("-", "--", "-.", ":")


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
        For a folder without sessions, sessions of different protocols, or a page that cannot be written.
    """
    found = sessions_in(Path(path))
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


@styled
def functions(protocol: Protocol, trials: pandas.DataFrame, fitted: pandas.DataFrame) -> Figure:
    """Draw the function of each participant, thin, and groups of all trials, by condition; over both levels."""
    figure = new_figure(7.2, 3.0)
    panels = figure.subplots(1, 2, sharey=True)
    for axes, over in zip(panels, ("requested", "delivered"), strict=True):
        for k, condition in enumerate(dict.fromkeys(trials["condition"])):
            some = _counted(trials[trials["condition"] == condition])
            if some.empty:
                continue
            x = np.linspace(float(some[over].min()), float(some[over].max()), 200)
            own = fitted[(fitted["condition"] == condition) & (fitted["level"] == over)].dropna(subset=["threshold"])
            for each in own.itertuples():
                y = probability(x, each.threshold, each.spread, each.guess, each.lapse)
                axes.plot(x, y, color=COLOURS[k % 6], lw=0.5, alpha=0.35)
            level, share, n = grouped(some[over], some["result"], 9)
            axes.scatter(level, share, 8 + 40 * n / n.max(), COLOURS[k % 6], label=condition, zorder=3)
        axes.set(xlabel=f"level {over}, {protocol.level_unit}", ylim=(-0.03, 1.03))
        axes.xaxis.set_major_locator(MaxNLocator(6))
    panels[0].set_ylabel("share right" if protocol.method.scores == "correct" else "comparison chosen")
    panels[1].legend(loc="lower right")
    return figure


@styled
def answers(protocol: Protocol, trials: pandas.DataFrame) -> Figure:
    """Draw the answers over both levels."""
    figure = new_figure(7.2, 3.0)
    panels = figure.subplots(1, 2, sharey=True)
    for axes, over in zip(panels, ("requested", "delivered"), strict=True):
        for k, condition in enumerate(dict.fromkeys(trials["condition"])):
            some = _counted(trials[trials["condition"] == condition])
            axes.plot(some[over], some["result"], ".", color=COLOURS[k % 6], alpha=0.5, label=condition)
        axes.set(xlabel=f"level {over}, {protocol.level_unit}")
    panels[0].set_ylabel("answer")
    panels[1].legend(loc="upper left")
    return figure


@styled
def thresholds(protocol: Protocol, fitted: pandas.DataFrame) -> Figure:
    """Draw what was found of each participant, joined over conditions, with the group's mean and its 95 % interval."""
    figure = new_figure(7.2, 3.0)
    panels = figure.subplots(1, 2, sharey=True)
    found = groups(fitted)
    for axes, over in zip(panels, ("requested", "delivered"), strict=True):
        some = fitted[fitted["level"] == over]
        names = list(dict.fromkeys(some["condition"]))
        for _, own in some.groupby("participant"):
            values = [float(own.loc[own["condition"] == name, "value"].mean()) for name in names]
            axes.plot(range(len(names)), values, color=GREY, lw=0.6, alpha=0.5, marker=".", ms=3)
        of = found[found["level"] == over].set_index("condition").loc[names]
        half = of["high"] - of["mean"]
        axes.errorbar(range(len(names)), of["mean"], half, fmt="o", color=BLUE, capsize=4, lw=1.6, ms=6, zorder=3)
        axes.set_xticks(range(len(names)), names)
        axes.set(xlim=(-0.5, len(names) - 0.5), title=f"over the level {over}")
        if (some["value"].dropna() >= 0).all():
            axes.set_ylim(bottom=0.0)
    name, _ = measure(protocol)
    panels[0].set_ylabel(name if name in ("exponent", "gain") else f"{name}, {protocol.level_unit}")
    return figure


@styled
def sequences(protocol: Protocol, trials: pandas.DataFrame) -> Figure:
    """Draw the levels asked for over the trials that counted, a panel for each of at most six participants."""
    people = list(dict.fromkeys(trials["participant"]))[:6]
    rows = -(-len(people) // 3)
    figure = new_figure(7.2, 0.5 + 1.6 * rows)
    panels = np.ravel(figure.subplots(rows, min(3, len(people)), sharex=True, sharey=True, squeeze=False))
    for axes, person in zip(panels, people, strict=False):
        own = _counted(trials[trials["participant"] == person])
        for k, (condition, some) in enumerate(own.groupby("condition", sort=False)):
            axes.plot(
                np.arange(1, len(some) + 1), some["requested"], LINES[k % 4], color=COLOURS[k % 6], lw=1.0,
                label=condition,
            )  # fmt: skip
        axes.set_title(person, fontsize=8)
    for axes in panels[len(people) :]:
        axes.set_axis_off()
    panels[0].legend(loc="upper right", frameon=True)
    figure.supxlabel("trial that counted", fontsize=8.5)
    figure.supylabel(f"level asked for, {protocol.level_unit}", fontsize=8.5)
    return figure


@styled
def converging(protocol: Protocol, trials: pandas.DataFrame) -> Figure:
    """Draw how the value of each participant settles, and the median half-width of its interval, over trials."""
    figure = new_figure(7.2, 3.0)
    left, right = figure.subplots(1, 2)
    for k, (condition, some) in enumerate(_counted(trials).groupby("condition", sort=False)):
        found = [
            convergence(protocol, own["requested"], own["result"]) for _, own in some.groupby("participant", sort=False)
        ]
        found = [each for each in found if len(each)]
        if not found:
            continue
        for each in found:
            left.plot(each["trial"], each["value"], color=COLOURS[k % 6], lw=0.5, alpha=0.35)
        whole = pandas.concat(found)
        by = whole.assign(half=0.5 * (whole["high"] - whole["low"])).groupby("trial")[["value", "half"]].median()
        left.plot(by.index, by["value"], LINES[k % 4], color=COLOURS[k % 6], lw=1.8, label=condition)
        right.plot(by.index, by["half"], LINES[k % 4], color=COLOURS[k % 6], lw=1.8, label=condition)
    name, _ = measure(protocol)
    left.set(xlabel="trials that counted", ylabel=f"{name}, {protocol.level_unit}")
    right.set(xlabel="trials that counted", ylabel=f"half of the 95 % interval, {protocol.level_unit}")
    for axes in (left, right):
        axes.set_ylim(bottom=0.0)
        axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    right.legend(loc="upper right")
    return figure


def _counted(trials: pandas.DataFrame) -> pandas.DataFrame:
    return trials[(trials["counted"] == 1) & np.isfinite(trials["result"])]


def _funnel_rows(trials: pandas.DataFrame) -> list[tuple[str, list[int]]]:
    """Return what became of trials, a row for each fate and a number for each condition."""
    table = funnel(trials).pivot_table("trials", "what", "condition", fill_value=0, sort=False, aggfunc="sum")
    names = list(dict.fromkeys(trials["condition"]))
    order = sorted(
        table.index, key=lambda what: (what == "counted", what.startswith(("rep", "kept")), what != "presented")
    )
    return [(what, [int(table.loc[what, name]) for name in names]) for what in order]
