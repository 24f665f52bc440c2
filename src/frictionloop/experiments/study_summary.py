"""What a study found: a number per participant and condition, of the group, how it settled, the fate of each trial."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas  # type: ignore[import-untyped]
from scipy.stats import linregress
from scipy.stats import t as student

from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.psychometric import COVERAGE, JND_Z, fit, grids_of, middle, probability
from frictionloop.quantities import FrictionloopError, must_be

LAPSE = 0.02
"""Lapse rate that is taken as known here (assumed); the fits leave it free."""


def convergence(protocol: Protocol, level: Any, result: Any) -> pandas.DataFrame:
    """Return median and 95 % interval of the threshold, or of the JND, after each trial.

    The posterior of threshold and spread on the grid and with the priors of `fit`; guess and lapse rate are taken as
    known.

    Parameters
    ----------
    protocol : Protocol
        What was asked.
    level, result : array
        Level and result, 1 or 0, of each trial, (trials,).

    Returns
    -------
    pandas.DataFrame
        Columns ``trial``, ``value``, ``low``, ``high``, a row for each trial; none where the levels are all alike.
    """
    x, r = np.asarray(level, float), np.asarray(result, float)
    columns = ["trial", "value", "low", "high"]
    if x.size == 0 or np.ptp(x) <= 0:
        return pandas.DataFrame(columns=columns)
    guess, spread = protocol.guess or LAPSE, measure(protocol)[0] == "JND"
    (a, b, _, _), prior = grids_of(protocol.method.extremes(), guess, nothing_at(protocol), lapse=np.array([LAPSE]))
    p = probability(x[:, None, None], a[None, :, None], b[None, None, :], guess, LAPSE)
    log_l = np.cumsum(np.where(r[:, None, None] > 0, np.log(p), np.log1p(-p)), axis=0) + prior[None, :, :, 0, 0]
    post = np.exp(log_l - log_l.max(axis=(1, 2), keepdims=True))
    marginal, grid = post.sum(axis=1 if spread else 2), JND_Z * b if spread else a
    return pandas.DataFrame([(n, *middle(row, grid)) for n, row in enumerate(marginal, 1)], columns=columns)


def nothing_at(protocol: Protocol) -> float | None:
    """Return the level at which the comparison is the standard; None of a task without right answers by chance."""
    if not protocol.guess:
        return None
    return 0.0 if protocol.stimulus.adds else protocol.stimulus.standard


LEVELS = ("requested", "delivered")
"""The two levels that everything is told over."""
MEASURES = {
    "magnitude": ("exponent", "Slope of log answer over log level"),
    "tracking": ("gain", "Slope of answer over level"),
    "adjustment": ("setting", "Mean level left as alike"),
}
"""What is found of a task, where it is not a psychometric function."""
LONGEST_LAG = 5
"""Trials by which an answer is looked for behind its level (assumed)."""


def measure(protocol: Protocol) -> tuple[str, str]:
    """Return the name of what is found of each participant, and what it is."""
    if protocol.task in MEASURES:
        return MEASURES[protocol.task]
    if protocol.task in ("2ifc", "2afc") and protocol.method.scores == "comparison":
        return "JND", "Half of 25% to 75%"
    if protocol.task in ("2ifc", "2afc"):
        return "threshold", "Level at 75% right, without lapses"
    return "threshold", "Level half the way from guesses to lapses"


def unit_found(protocol: Protocol) -> str:
    """Return the unit of what is found of each participant; 1 for a pure number."""
    return {"exponent": "1", "gain": f"1/{protocol.level_unit}"}.get(measure(protocol)[0], protocol.level_unit)


def named_found(protocol: Protocol) -> str:
    """Return the name of what is found with its unit, for heads of tables and axes."""
    return ", ".join(each for each in (measure(protocol)[0], unit_found(protocol)) if each != "1")


def counted(trials: pandas.DataFrame) -> pandas.DataFrame:
    """Return the trials that the method was told of."""
    return trials[(trials["counted"] == 1) & np.isfinite(trials["result"])]


def fits(protocol: Protocol, trials: pandas.DataFrame, levels: Sequence[str] = LEVELS) -> pandas.DataFrame:
    """Return one row per participant, condition and kind of level; one without a value says why.

    Parameters
    ----------
    protocol : Protocol
        What was asked.
    trials : pandas.DataFrame
        Rows as in ``trials.tsv``.
    levels : sequence of str
        Kinds of level: requested, delivered.

    Returns
    -------
    pandas.DataFrame
        ``value`` is what `measure` names, in ``unit``, ``low`` and ``high`` its 95 % interval; the other columns are
        those of `fit`, where there is a function.
    """
    rows = []
    for (participant, condition), some in trials.groupby(["participant", "condition"], sort=False):
        known = counted(some)
        for over in levels:
            row: dict[str, Any] = {"participant": participant, "condition": condition, "level": over}
            row |= {"trials": len(known), "value": math.nan, "low": math.nan, "high": math.nan, "why": ""}
            try:
                row |= _found(protocol, known[over].to_numpy(float), known["result"].to_numpy(float))
            except FrictionloopError as error:
                row["why"] = str(error)
            rows.append(row)
    table = pandas.DataFrame(rows).assign(unit=unit_found(protocol))
    if measure(protocol)[0] in ("JND", "threshold"):
        table = table.reindex(columns=list(dict.fromkeys([*table.columns, "threshold", "spread", "guess", "lapse"])))
        if protocol.stimulus.standard:
            table["weber"] = table["value"] / protocol.stimulus.standard
    return table


def _found(protocol: Protocol, level: Any, result: Any) -> dict[str, Any]:
    if protocol.task == "magnitude":
        known = (level > 0) & (result > 0)  # others have no logarithm
        return _slope(np.log(level[known]), np.log(result[known]))
    if protocol.task == "tracking":
        return _tracked(level, 0.01 * result)
    if protocol.task == "adjustment":
        left = level[result == 0]
        if left.size < 2:
            raise FrictionloopError(f"{left.size} settings; 2 are needed")
        found = _mean(left, left.size)
        return {"value": found["mean"], "low": found["low"], "high": found["high"], "spread": found["sd"]}
    function = fit(level, result, protocol.guess or None, low=nothing_at(protocol), ends=protocol.method.extremes())
    value = [JND_Z * each for each in function[3:6]] if measure(protocol)[0] == "JND" else function[:3]
    return function._asdict() | dict(zip(("value", "low", "high"), value, strict=True))


def _slope(x: Any, y: Any) -> dict[str, Any]:
    if x.size < 3 or np.ptp(x) <= 0:
        raise must_be("slope", x.size, "at least 3, at two levels", "trials")
    if np.ptp(y) <= 0:
        raise FrictionloopError(f"slope: {x.size} answers, all alike")
    line = linregress(x, y)
    half = float(student.ppf(0.5 + 0.5 * COVERAGE, x.size - 2)) * float(line.stderr)
    slope = float(line.slope)
    return {"value": slope, "low": slope - half, "high": slope + half, "correlation": float(line.rvalue)}


def _tracked(level: Any, answer: Any) -> dict[str, Any]:
    """Return the slope at the lag, in trials, at which answer and level correlate most."""
    best: dict[str, Any] = {}
    for lag in range(min(LONGEST_LAG, level.size - 3) + 1):
        found = _slope(level[: level.size - lag], answer[lag:]) | {"lag_trials": lag}
        if not best or found["correlation"] > best["correlation"]:
            best = found
    if not best:
        raise FrictionloopError(f"{level.size} trials; 4 are needed")
    return best


CELLS = 80
"""Levels that delivered ones are rounded to where trials of all participants are fitted together (assumed)."""


def pooled(protocol: Protocol, trials: pandas.DataFrame) -> pandas.DataFrame:
    """Return one psychometric function through the trials of all participants, by condition and kind of level.

    Guess and lapse rate are free where a guess is not 1/2 by the task: four parameters. Participants differ, so its
    spread holds theirs; the dispersion says by how much independence fails. Without a function there are no rows.

    Parameters
    ----------
    protocol, trials
        As of `fits`.
    """
    if measure(protocol)[0] not in ("JND", "threshold"):
        return pandas.DataFrame()
    together, by = trials.assign(participant="all"), trials.groupby("condition")
    for over in LEVELS:
        step = (by[over].transform("max") - by[over].transform("min")) / CELLS
        together[over] = np.round(trials[over] / step.where(step > 0.0, 1.0)) * step.where(step > 0.0, 1.0)
    people = trials.groupby("condition", sort=False)["participant"].nunique()
    found = fits(protocol, together).drop(columns="participant")
    return found.assign(participants=found["condition"].map(people))


def groups(fitted: pandas.DataFrame) -> pandas.DataFrame:
    """Return mean, standard deviation and 95 % interval over participants, by condition and level; of one its own."""
    rows = []
    for (condition, over), some in fitted.groupby(["condition", "level"], sort=False):
        known = some.dropna(subset=["value"])
        row = {"condition": condition, "level": over, **_mean(known["value"].to_numpy(), len(some))}
        if len(known) == 1:
            row |= known[["low", "high"]].iloc[0].to_dict()
        rows.append(row)
    return pandas.DataFrame(rows)


def contrasts(protocol: Protocol, fitted: pandas.DataFrame) -> pandas.DataFrame:
    """Return how much each condition differs from the protocol's first in the same participants, as of `groups`."""
    first, *others = (each.name for each in protocol.conditions)
    rows, unit = [], unit_found(protocol)
    for over, some in fitted.groupby("level", sort=False):
        values = some.pivot(index="participant", columns="condition", values="value").reindex(columns=[first, *others])
        for other in others:
            both = (values[other] - values[first]).dropna().to_numpy()
            rows.append({"condition": f"{other} - {first}", "level": over, **_mean(both, len(values)), "unit": unit})
    return pandas.DataFrame(rows)


def _mean(values: Any, people: int) -> dict[str, Any]:
    """Return the mean of participants' values with its 95 % interval by the t-distribution, and how many have none."""
    n = len(values)
    mean, sd = float(values.mean()) if n else math.nan, float(values.std(ddof=1)) if n > 1 else math.nan
    half = float(student.ppf(0.5 + 0.5 * COVERAGE, n - 1)) * sd / math.sqrt(n) if n > 1 else math.nan
    return {"participants": n, "without": people - n, "mean": mean, "sd": sd, "low": mean - half, "high": mean + half}


def funnel(trials: pandas.DataFrame) -> pandas.DataFrame:
    """Return what became of the trials of each condition: a row for every way in which one did not count."""
    rows = []
    for condition, some in trials.groupby("condition", sort=False):
        rows.append((condition, "presented", len(some)))
        rows.append((condition, "practice", int((some["phase"] == "practice").sum())))
        rows += [(condition, f"catch, {what}", n) for what, n in _caught(some[some["phase"] == "catch"])]
        main = some[some["phase"] == "main"]
        bad = main[main["valid"] == 0]
        kinds = bad["reason"].str.replace(r"=[^ ;]*", "", regex=True).str.replace(r" in \d", "", regex=True)
        kinds = kinds.str.split("; ").map(lambda parts: "; ".join(dict.fromkeys(parts)))
        for again, what in ((1, "repeated"), (0, "kept with a mark")):
            counts = kinds[bad["again"] == again].value_counts()
            rows += [(condition, f"{what}: {reason}", int(n)) for reason, n in counts.items()]
        rows.append((condition, "counted", int(main["counted"].sum())))
    return pandas.DataFrame(rows, columns=["condition", "what", "trials"])


def _caught(catch: pandas.DataFrame) -> list[tuple[str, int]]:
    """Return how many catch trials were answered right, wrong, and not validly or without a right answer."""
    valid = catch[catch["valid"] == 1]
    right, wrong = (int((valid["correct"] == value).sum()) for value in (1.0, 0.0))
    return [("right", right), ("wrong", wrong), ("neither", len(catch) - right - wrong)]
