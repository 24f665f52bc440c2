"""The psychometric function: how often an answer is given at a level, and fitting it with its intervals."""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.special import expit, ndtr, ndtri
from scipy.stats import beta as beta_law
from scipy.stats import chi2

from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.checks import Array, numbers

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
LEVELS = 6
"""Groups of about equal size that the dispersion is told of, and figures show (assumed)."""


class Fit(NamedTuple):
    """A fitted function; intervals are the middle 95 % of the posterior."""

    threshold: float
    """a, where F is 1/2: the mean of its posterior."""
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
    """Whether the interval of a reaches an end of what was thought possible: the levels do not fix it."""


def fit(level: Any, result: Any, guess: float | None = 0.5, shape: Shape = "normal", low: float | None = None) -> Fit:
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
        Least threshold that is thought possible; a range beside the least level if not given.

    Returns
    -------
    Fit
        Threshold and spread have flat priors, that of the spread in its logarithm.

    Raises
    ------
    FrictionloopError
        For fewer than 5 trials, or levels or results that are all alike.
    """
    x, r = numbers("level", level, ""), numbers("result", result, "", 0.0, 1.0)
    if x.size != r.size or x.size < 5 or np.ptp(x) <= 0:
        raise must_be("fit", x.size, "at least 5, at two levels", "trials")
    if np.ptp(r) <= 0:
        raise FrictionloopError(f"fit: {x.size} answers, all alike")
    grids = _grids(x, guess, low)
    log_l = _log_likelihood(x, r, grids, shape)
    log_l += _log_prior(grids[2])[None, None, :, None]
    if guess is None:
        log_l += _log_prior(grids[3])
    post = np.exp(log_l - log_l.max())
    post /= post.sum()
    a, b, lapse, g = (_marginal(post, axis, grid) for axis, grid in enumerate(grids))
    dispersion, limit = _dispersion(x, r, probability(x, a[0], b[0], g[0], lapse[0], shape))
    return Fit(*a, *b, lapse[0], g[0], dispersion, limit, x.size, a[1] < grids[0][1] or a[2] > grids[0][-2])


def _grids(x: Array, guess: float | None, low: float | None) -> tuple[Array, Array, Array, Array]:
    span = float(np.ptp(x))
    least = float(x.min()) - 0.5 * span if low is None else low
    return (
        np.linspace(least, float(x.max()) + 0.5 * span, POINTS[0]),
        np.geomspace(span / 50.0, 2.0 * span, POINTS[1]),
        np.linspace(0.0, LARGEST_LAPSE, POINTS[2]),
        np.linspace(0.0, LARGEST_LAPSE, POINTS[2]) if guess is None else np.array([guess]),
    )


def _log_likelihood(x: Array, r: Array, grids: tuple[Array, ...], shape: Shape) -> Array:
    a, b, lapse, g = np.meshgrid(*grids, indexing="ij", sparse=True)
    total = np.zeros(tuple(each.size for each in grids))
    values, where = np.unique(x, return_inverse=True)
    right, all_ = np.bincount(where, r), np.bincount(where)
    for level, k, n in zip(values.tolist(), right.tolist(), all_.tolist(), strict=True):
        p = np.clip(probability(level, a, b, g, lapse, shape), 1e-9, 1 - 1e-9)
        total += k * np.log(p) + (n - k) * np.log1p(-p)
    return total


def _log_prior(rates: Array) -> Array:
    return np.asarray(beta_law.logpdf(np.clip(rates, 1e-3, None), *LAPSE_PRIOR))


def _marginal(post: Array, axis: int, grid: Array) -> tuple[float, float, float]:
    marginal = post.sum(axis=tuple(k for k in range(4) if k != axis))
    mean = float(marginal @ grid)
    if grid.size == 1:
        return mean, mean, mean
    # Each value stands for the cell around it.
    edges = np.concatenate([grid[:1], 0.5 * (grid[1:] + grid[:-1]), grid[-1:]])
    total = np.concatenate([[0.0], np.cumsum(marginal)])
    low, high = np.interp([0.025, 0.975], total, edges)
    return mean, float(low), float(high)


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


def jnd(of: Fit, scores: str) -> float:
    """Return the just noticeable difference: 75 % right, or half the way from 25 to 75 % comparison chosen."""
    return of.threshold if scores == "correct" else JND_Z * of.spread
