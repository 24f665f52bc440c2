"""How what is found of a participant settles from trial to trial."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas  # type: ignore[import-untyped]

from frictionloop.experiments.function_fit import POINTS
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.psychometric import JND_Z, probability

LAPSE = 0.02
"""Lapse rate that is taken as known here (assumed); the fits leave it free."""


def convergence(protocol: Protocol, level: Any, result: Any) -> pandas.DataFrame:
    """Return mean and 95 % interval of the threshold, or of the JND, after each trial.

    The posterior of threshold and spread on the grid of `fit`, both priors flat, that of the spread in its logarithm;
    guess and lapse rate are taken as known.

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
    comparison = protocol.method.scores == "comparison"
    span = float(np.ptp(x))
    least = 0.0 if not comparison and protocol.guess else float(x.min()) - 0.5 * span
    a = np.linspace(least, float(x.max()) + 0.5 * span, POINTS[0])
    b = np.geomspace(span / 50.0, 2.0 * span, POINTS[1])
    guess = LAPSE if comparison or not protocol.guess else protocol.guess
    p = probability(x[:, None, None], a[None, :, None], b[None, None, :], guess, LAPSE)
    log_l = np.cumsum(np.where(r[:, None, None] > 0, np.log(p), np.log1p(-p)), axis=0)
    post = np.exp(log_l - log_l.max(axis=(1, 2), keepdims=True))
    marginal = post.sum(axis=1 if comparison else 2)
    marginal /= marginal.sum(axis=1, keepdims=True)
    grid = JND_Z * b if comparison else a
    total = np.cumsum(marginal, axis=1)
    ends = np.array([np.interp([0.025, 0.975], row, grid) for row in total])
    found = np.column_stack([np.arange(1, x.size + 1), marginal @ grid, ends])
    return pandas.DataFrame(found, columns=columns)
