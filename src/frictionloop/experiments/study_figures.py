"""Figures of a study: functions, answers, what was found of each participant, how it settled, sequences."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas  # type: ignore[import-untyped]
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.psychometric import grouped, probability
from frictionloop.experiments.study_summary import convergence, counted, groups, named_found
from frictionloop.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION, new_figure, styled

COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, GREY)
LINES = ("-", "--", "-.", ":")


@styled
def functions(protocol: Protocol, trials: pandas.DataFrame, fitted: pandas.DataFrame) -> Figure:
    """Draw the function of each participant, thin, and groups of all trials, by condition; over both levels."""

    def draw(axes: Axes, over: str, condition: str, some: pandas.DataFrame, colour: str) -> None:
        x = np.linspace(float(some[over].min()), float(some[over].max()), 200)
        own = fitted[(fitted["condition"] == condition) & (fitted["level"] == over)].dropna(subset=["threshold"])
        for each in own.itertuples():
            y = probability(x, each.threshold, each.spread, each.guess, each.lapse)
            axes.plot(x, y, color=colour, lw=0.5, alpha=0.35)
        level, share, n = grouped(some[over], some["result"], 9)
        axes.scatter(level, share, 8 + 40 * n / n.max(), colour, label=condition, zorder=3)
        axes.set_ylim(-0.03, 1.03)

    return _over_levels(protocol, trials, draw, share_of(protocol), "lower right")


@styled
def answers(protocol: Protocol, trials: pandas.DataFrame) -> Figure:
    """Draw the answers over both levels."""

    def draw(axes: Axes, over: str, condition: str, some: pandas.DataFrame, colour: str) -> None:
        axes.plot(some[over], some["result"], ".", color=colour, alpha=0.5, label=condition)

    return _over_levels(protocol, trials, draw, "answer", "upper left")


def _over_levels(
    protocol: Protocol,
    trials: pandas.DataFrame,
    draw: Callable[[Axes, str, str, pandas.DataFrame, str], None],
    named: str,
    legend: str,
) -> Figure:
    """Draw the trials that counted over both levels, a panel for each, condition by condition."""
    figure = new_figure(7.2, 3.0)
    panels = figure.subplots(1, 2, sharey=True)
    for axes, over in zip(panels, ("requested", "delivered"), strict=True):
        for k, condition in enumerate(dict.fromkeys(trials["condition"])):
            some = counted(trials[trials["condition"] == condition])
            if not some.empty:
                draw(axes, over, condition, some, COLOURS[k % 6])
        axes.set_xlabel(f"level {over}, {protocol.level_unit}")
        axes.xaxis.set_major_locator(MaxNLocator(6))
    panels[0].set_ylabel(named)
    _legend(panels[1], legend)
    return figure


def _legend(axes: Axes, loc: Any, **more: Any) -> None:
    """Draw a legend where something was drawn."""
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc=loc, **more)


def share_of(protocol: Protocol) -> str:
    """Return in words the share of answers that a psychometric function is of."""
    if protocol.task in ("yes_no", "same_different"):
        return f"share of {protocol.choices[0 if protocol.task == 'yes_no' else 1]}"
    return "share right" if protocol.method.scores == "correct" else "comparison chosen"


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
    panels[0].set_ylabel(named_found(protocol))
    return figure


@styled
def sequences(protocol: Protocol, trials: pandas.DataFrame) -> Figure:
    """Draw the levels asked for over the trials that counted, a panel for each of at most six participants."""
    people = list(dict.fromkeys(trials["participant"]))[:6]
    rows = -(-len(people) // 3)
    figure = new_figure(7.2, 0.5 + 1.6 * rows)
    panels = np.ravel(figure.subplots(rows, min(3, len(people)), sharex=True, sharey=True, squeeze=False))
    for axes, person in zip(panels, people, strict=False):
        own = counted(trials[trials["participant"] == person])
        for k, (condition, some) in enumerate(own.groupby("condition", sort=False)):
            axes.plot(
                np.arange(1, len(some) + 1), some["requested"], LINES[k % 4], color=COLOURS[k % 6], lw=1.0,
                label=condition,
            )  # fmt: skip
        axes.set_title(person, fontsize=8)
    for axes in panels[len(people) :]:
        axes.set_axis_off()
    _legend(panels[0], "upper right", frameon=True)
    figure.supxlabel("trial that counted", fontsize=8.5)
    figure.supylabel(f"level asked for, {protocol.level_unit}", fontsize=8.5)
    return figure


@styled
def converging(protocol: Protocol, trials: pandas.DataFrame) -> Figure:
    """Draw how the value of each participant settles, and the median half-width of its interval, over trials."""
    figure = new_figure(7.2, 3.0)
    left, right = figure.subplots(1, 2)
    for k, (condition, some) in enumerate(counted(trials).groupby("condition", sort=False)):
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
    left.set(xlabel="trials that counted", ylabel=named_found(protocol))
    right.set(xlabel="trials that counted", ylabel=f"half of the 95 % interval, {protocol.level_unit}")
    right.set_ylim(bottom=0.0)
    if left.get_ylim()[0] > 0.0:
        left.set_ylim(bottom=0.0)
    for axes in (left, right):
        axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    _legend(right, "upper right")
    return figure
