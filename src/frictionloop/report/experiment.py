"""The page of a study: who took part, what counted, psychometric functions, thresholds and sequences."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas  # type: ignore[import-untyped]
from jinja2 import Environment, PackageLoader
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from frictionloop.experiments.fit import grouped
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.psychometric import probability
from frictionloop.experiments.summary import fits, funnel, groups, measure
from frictionloop.quantities import replacing
from frictionloop.report.style import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION, inline, new_figure, styled, svg

COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, GREY)
LINES = ("-", "--", "-.", ":")


def page(protocol: Protocol, trials: pandas.DataFrame, about: str) -> str:
    """Return a study as one self-contained HTML page.

    Parameters
    ----------
    protocol : Protocol
        What was asked.
    trials : pandas.DataFrame
        Rows as in ``trials.tsv``.
    about : str
        Where the trials are from, in words.
    """
    fitted = fits(protocol, trials)
    name, _ = measure(protocol)
    figures = {
        "thresholds": (thresholds(protocol, fitted), f"{name} by condition and participant"),
        "sequences": (sequences(protocol, trials), "Levels asked for over trials"),
    }
    if name in ("threshold", "JND"):
        figures["functions"] = (functions(protocol, trials, fitted), "Psychometric functions by condition")
    else:
        figures["answers"] = (answers(protocol, trials), "Answers over levels")
    drawn = {name: inline(svg(figure, name), label) for name, (figure, label) in figures.items()}
    shown = Environment(loader=PackageLoader("frictionloop.report"), autoescape=True, trim_blocks=True)
    shown.filters["number"] = number
    return shown.get_template("experiment.html.jinja").render(
        protocol=protocol,
        about=about,
        people=trials["participant"].nunique(),
        figures=drawn,
        groups=groups(fitted).to_dict("records"),
        fits=fitted.to_dict("records"),
        funnel=_funnel_rows(trials),
        measure=measure(protocol),
        weber="weber" in fitted,
        conditions=list(dict.fromkeys(trials["condition"])),
    )


def write_page(protocol: Protocol, trials: pandas.DataFrame, about: str, path: Path) -> None:
    """Write the page of a study, and beside it its tables as TSV.

    Raises
    ------
    FrictionloopError
        For a file that cannot be written.
    """
    text, fitted = page(protocol, trials, about), fits(protocol, trials)
    tables = {"fits": fitted, "groups": groups(fitted), "funnel": funnel(trials)}
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")
    for name, table in tables.items():
        with replacing(path.with_name(f"{path.stem}-{name}.tsv")) as beside:
            table.to_csv(beside, sep="\t", index=False, na_rep="n/a")


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
    panels[0].legend(loc="upper right")
    figure.supxlabel("trial that counted", fontsize=8.5)
    figure.supylabel(f"level asked for, {protocol.level_unit}", fontsize=8.5)
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
