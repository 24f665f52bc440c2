"""The psychometric function: how often an answer is given at a level."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from scipy.special import expit, ndtr, ndtri

from frictionloop.quantities.checks import Array

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
