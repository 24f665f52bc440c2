"""The psychometric function: how often an answer is given at a level, and fitting it with its intervals."""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.special import betaln, expit, logsumexp, ndtr, ndtri, xlog1py, xlogy
from scipy.stats import beta as beta_law
from scipy.stats import chi2

from frictionloop.quantities import Array, FrictionloopError, must_be
from frictionloop.quantities.value_checks import numbers

Shape = Literal["normal", "logistic", "weibull"]


def probability(
    level: Any, threshold: Any, spread: Any, guess: Any = 0.5, lapse: Any = 0.0, shape: Shape = "normal"
) -> Array:
    """Return psi(x) = g + (1 - g - l) F(x; a, b), of broadcast arguments (Wichmann & Hill 2001).

    Parameters
    ----------
    level : array
        Levels x.
    threshold, spread : array
        a and b. normal: F = Phi((x - a)/b). logistic: F = 1/(1 + e^(-(x - a)/s)), s = b sqrt(pi/8), as steep at a.
        weibull: F = 1 - 2^(-(x/a)^(1/b)), 0 for x below 0. F(a) is 1/2 in all of them.
    guess, lapse : array
        g and l, the distances from 0 and from 1 at the two ends.
    shape : {"normal", "logistic", "weibull"}
        F.
    """
    x, a, b = np.asarray(level, float), np.asarray(threshold, float), np.asarray(spread, float)
    if shape == "weibull":
        ratio = np.maximum(x, 0.0) / a
        f = -np.expm1(-math.log(2.0) * ratio ** (1.0 / b))
    else:
        z = (x - a) / b
        f = ndtr(z) if shape == "normal" else expit(z * math.sqrt(8.0 / math.pi))
    return np.asarray(guess + (1.0 - np.asarray(guess) - np.asarray(lapse)) * f)


JND_Z = float(ndtri(0.75))
"""z(3/4): half the way from 25 % to 75 % of a normal distribution, over its standard deviation."""


POINTS = (61, 31, 9)
"""Values of threshold, spread and lapse rate on the grid (assumed)."""
LARGEST_LAPSE = 0.2
"""Of the grid (assumed)."""
LAPSE_PRIOR = (1.0, 10.0)
"""Beta prior of the lapse rate, and of the guess rate where it is free (psignifit 4's)."""
NOTHING_PRIOR = (1.0, 6.0)
"""Beta prior of F where nothing is there: 0 by right, more where F is not the observer's own (assumed: with it the
intervals of both kinds of `studies.threshold_coverage` hold)."""
BEYOND = 0.5
"""Share of the stimulus range by which a threshold may lie outside it, ever less likely (psignifit 4's)."""
LEVELS = 6
"""Groups of about equal size that the dispersion is told of, and figures show (assumed)."""
COVERAGE = 0.95
"""Of intervals: the middle of a posterior."""


class Fit(NamedTuple):
    """A fitted function; values are medians of the posterior, intervals its middle 95 %."""

    threshold: float
    """a, where F is 1/2."""
    threshold_low: float
    threshold_high: float
    spread: float
    """b."""
    spread_low: float
    spread_high: float
    lapse: float
    guess: float
    dispersion: float
    """Pearson's X^2 of groups of trials over their number less two: near 1 if the function and independence hold."""
    dispersion_limit: float
    """97.5 % quantile of the dispersion where they hold, by chi-square; above it the trials are overdispersed."""
    trials: int
    at_edge: bool
    """Whether the interval of a leaves the stimulus range: the levels do not fix it."""


def fit(
    level: Any,
    result: Any,
    guess: float | None = 0.5,
    shape: Shape = "normal",
    low: float | None = None,
    ends: tuple[float, float] | None = None,
) -> Fit:
    """Return the fit of g + (1 - g - l) F(x; a, b) to single trials.

    Parameters
    ----------
    level, result : array
        Level and result, 1 or 0, of each trial.
    guess : float, optional
        g; None lets it be free, with the same prior as the lapse rate.
    shape : str
        F, as of `probability`.
    low : float, optional
        Level at which nothing is there to be told: no threshold is below, and F there is small.
    ends : (float, float), optional
        Stimulus range, that of the levels if not given. The prior of the threshold is flat in it and falls as a cosine
        to half a range outside; that of the spread is flat, with ``low`` in its logarithm.

    Raises
    ------
    FrictionloopError
        For fewer than 5 trials, levels or results that are all alike, or answers that guessing alone explains better
        than the functions do, by their Bayes factor.
    """
    x, r = numbers("level", level, ""), numbers("result", result, "", 0.0, 1.0)
    if x.size != r.size or x.size < 5 or np.ptp(x) <= 0:
        raise must_be("fit", x.size, "at least 5, at two levels", "trials")
    if np.ptp(r) <= 0:
        raise FrictionloopError(f"fit: {x.size} answers, all alike")
    within = ends if ends and ends[0] < ends[1] else (float(x.min()), float(x.max()))
    grids, prior = grids_of(within, guess, low, shape)
    joint = _log_likelihood(x, r, grids, shape) + prior
    if logsumexp(joint) - logsumexp(np.broadcast_to(prior, joint.shape)) < _log_guessed(r, guess):
        raise FrictionloopError("fit: answers do not go with the level")
    post = np.exp(joint - joint.max())
    a, b, lapse, g = (
        middle(post.sum(axis=tuple(k for k in range(4) if k != axis)), grid) for axis, grid in enumerate(grids)
    )
    dispersion, limit = _dispersion(x, r, probability(x, a[0], b[0], g[0], lapse[0], shape))
    return Fit(*a, *b, lapse[0], g[0], dispersion, limit, x.size, a[1] < within[0] or a[2] > within[1])


def grids_of(
    ends: tuple[float, float],
    guess: float | None,
    low: float | None,
    shape: Shape = "normal",
    lapse: Array | None = None,
) -> tuple[tuple[Array, Array, Array, Array], Array]:
    """Return values of threshold, spread, lapse and guess rate, and the logarithm of their prior, as of `fit`."""
    span, rates = ends[1] - ends[0], np.linspace(0.0, LARGEST_LAPSE, POINTS[2])
    grids = (
        np.linspace(ends[0] - BEYOND * span if low is None else low, ends[1] + BEYOND * span, POINTS[0]),
        np.geomspace(span / 50.0, 2.0 * span, POINTS[1]),
        rates if lapse is None else lapse,
        rates if guess is None else np.array([guess]),
    )
    a, b, rate, g = np.meshgrid(*grids, indexing="ij", sparse=True)
    outside = np.clip(np.maximum(ends[0] - a, a - ends[1]) / (BEYOND * span), 0.0, 1.0)
    prior = np.log(np.maximum(0.5 + 0.5 * np.cos(math.pi * outside), 1e-12)) + _log_prior(rate)
    if guess is None:
        prior = prior + _log_prior(g)
    return grids, prior + (np.log(b) if low is None else nothing_there(low, a, b, shape))


def nothing_there(low: float, a: Array, b: Array, shape: Shape = "normal") -> Array:
    """Return the logarithm of the prior of functions by F(low), where nothing is there to be told."""
    return _log_prior(probability(low, a, b, 0.0, 0.0, shape), NOTHING_PRIOR)


def _log_likelihood(x: Array, r: Array, grids: tuple[Array, ...], shape: Shape) -> Array:
    a, b, lapse, g = np.meshgrid(*grids, indexing="ij", sparse=True)
    total = np.zeros(tuple(each.size for each in grids))
    values, where = np.unique(x, return_inverse=True)
    right, all_ = np.bincount(where, r), np.bincount(where)
    for level, k, n in zip(values.tolist(), right.tolist(), all_.tolist(), strict=True):
        p = np.clip(probability(level, a, b, g, lapse, shape), 1e-9, 1 - 1e-9)
        total += k * np.log(p) + (n - k) * np.log1p(-p)
    return total


def _log_guessed(r: Array, guess: float | None) -> float:
    """Return the log likelihood of answers that do not know the level; of any one rate where there is no guess."""
    k, wrong = float(r.sum()), float(r.size - r.sum())
    return float(betaln(1.0 + k, 1.0 + wrong) if guess is None else xlogy(k, guess) + xlog1py(wrong, -guess))


def _log_prior(rates: Array, law: tuple[float, float] = LAPSE_PRIOR) -> Array:
    return np.asarray(beta_law.logpdf(np.clip(rates, 1e-3, None), *law))


def middle(marginal: Array, grid: Array) -> tuple[float, float, float]:
    """Return the median of weights on a grid and the ends of their middle 95 %; each value stands for its cell."""
    edges = np.concatenate([grid[:1], 0.5 * (grid[1:] + grid[:-1]), grid[-1:]])
    total = np.concatenate([[0.0], np.cumsum(marginal)]) / marginal.sum()
    found = np.interp([0.5, 0.5 - 0.5 * COVERAGE, 0.5 + 0.5 * COVERAGE], total, edges)
    return float(found[0]), float(found[1]), float(found[2])


def grouped(x: Any, r: Any, groups: int = LEVELS) -> tuple[Array, Array, Array]:
    """Return mean level, share of results and number of trials of groups: single levels if few, else of equal size."""
    x, r = np.asarray(x, float), np.asarray(r, float)
    values, where = np.unique(x, return_inverse=True)
    if values.size > 2 * groups:
        order = np.argsort(x, kind="stable")
        where = np.empty(x.size, int)
        where[order] = np.arange(x.size) * groups // x.size
    count = np.bincount(where)
    return np.bincount(where, x) / count, np.bincount(where, r) / count, count.astype(float)


def _dispersion(x: Array, r: Array, p: Array) -> tuple[float, float]:
    """Return the dispersion and its limit."""
    level, share, n = grouped(x, r)
    _, expected, _ = grouped(x, p)
    if (free := level.size - 2) <= 0:
        return math.nan, math.nan
    expected = np.clip(expected, 1e-3, 1 - 1e-3)
    found = float(np.sum(n * (share - expected) ** 2 / (expected * (1 - expected))) / free)
    return found, float(chi2.ppf(0.975, free)) / free
