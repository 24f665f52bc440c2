"""Both kinds of R2 over several runs together, from the moments of each."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

Array = np.ndarray


class Moments(NamedTuple):
    """Moments of runs over their scored periods; arrays whose first axis is the runs that are pooled."""

    periods: Array
    rms_error: Array
    mean_r: Array
    mean_f: Array
    std_r: Array
    std_f: Array
    slope: Array
    """Of the regression of f on r, covariance over variance of r."""


class Pooled(NamedTuple):
    """Fit over all runs: 1 - sum (f - r)^2 / sum (r - mean r)^2, squared correlation, and rms of f - r."""

    r2_identity: Array
    r2_regression: Array
    rms_error: Array


def pooled(runs: Moments) -> Pooled:
    """Return the fit over runs taken as one record; NaN where a run has no value or the pooled r is constant.

    With m the means over everything, sum (r - m_r)^2 = sum_i n_i (s_ri^2 + (m_ri - m_r)^2), and so for f and for their
    product, in which slope_i s_ri^2 is the covariance within run i.
    """
    n = runs.periods.sum(axis=0)
    weight = runs.periods / n
    from_r, from_f = (each - np.sum(weight * each, axis=0) for each in (runs.mean_r, runs.mean_f))
    inside = runs.slope * runs.std_r**2
    variance_r = np.sum(weight * (runs.std_r**2 + from_r**2), axis=0)
    variance_f = np.sum(weight * (runs.std_f**2 + from_f**2), axis=0)
    covariance = np.sum(weight * (inside + from_r * from_f), axis=0)
    error2 = np.sum(weight * runs.rms_error**2, axis=0)
    spread = np.where(variance_r > 0.0, variance_r, np.nan)
    moving = np.where(variance_f > 0.0, variance_f, np.nan)
    return Pooled(1.0 - error2 / spread, covariance**2 / (spread * moving), np.sqrt(error2))


def pooled_rms(count: Array, rms: Array) -> Array:
    """Return the rms over runs together, along the first axis."""
    return np.asarray(np.sqrt(np.sum(count * rms**2, axis=0) / np.sum(count, axis=0)))
