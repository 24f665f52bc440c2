"""Just-noticeable differences of force, friction and time: what a person tells apart, of things that are felt."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from frictionloop.perception.checks import Array, numbers

FRICTION_WEBER = 0.11
"""Weber fraction of a transient decrease of friction, the same dry and moist (Gueorguiev 2017)."""
FORCE_WEBER = (0.07, 0.10)
"""Weber fraction of a force of 0.5 N or more, lowest and highest (doi:10.1038/s41598-022-12010-0; Pang 1991: 0.07)."""
SMALL_FORCE_WEBER = (0.15, 0.27)
"""Weber fraction of a force below 0.5 N, lowest and highest (doi:10.1038/s41598-022-12010-0)."""
SMALL_FORCE_N = 0.5
"""Force below which the Weber fraction is larger (same source)."""
COEFFICIENT_WEBER = 0.18
"""Weber fraction of the coefficient of friction on a TPad (Samur 2009; assumed: from memory)."""
TIMING_JND_S = 2.3e-3
"""Difference told apart in the duration of a friction transition (Gueorguiev 2019, PubMed 30676978: 2.3 to 2.4 ms)."""


class Jnd(NamedTuple):
    """Smallest and largest published just-noticeable difference, in N."""

    low_n: Array
    high_n: Array


def force_jnd_n(force_n: ArrayLike) -> Jnd:
    """Return the difference in a held force that is just noticed: 7 to 10 % from 0.5 N on, 15 to 27 % below.

    Parameters
    ----------
    force_n
        Forces in N, not negative, of any shape. Measured from 2.5 to 10 N (Pang 1991) and around 0.5 N.

    Raises
    ------
    FrictionloopError
        For a force that is negative or no number.
    """
    force = numbers("force_n", force_n, "N", 0.0)
    small = force < SMALL_FORCE_N
    low, high = (np.where(small, below, above) for below, above in zip(SMALL_FORCE_WEBER, FORCE_WEBER, strict=True))
    return Jnd(np.asarray(low * force), np.asarray(high * force))


def friction_jnd_n(force_n: ArrayLike) -> Array:
    """Return 0.11 f, the change of friction that is just noticed while sliding (Gueorguiev 2017).

    Parameters
    ----------
    force_n
        Friction forces in N, not negative, of any shape.

    Raises
    ------
    FrictionloopError
        For a force that is negative or no number.
    """
    return FRICTION_WEBER * numbers("force_n", force_n, "N", 0.0)


def slow_error_felt(error_n: ArrayLike, force_n: ArrayLike) -> NDArray[np.bool_]:
    """Return whether a constant or slow error is felt: |e| > 0.11 f (33 mN at 0.3 N, 99 mN at 0.9 N).

    It takes over where the index D ends, below 1 Hz. The paper's 20 mN passes at every level of the paper.

    Parameters
    ----------
    error_n
        Errors e of the friction force in N, of any shape.
    force_n
        Forces f asked for in N, not negative, of a shape that broadcasts.

    Raises
    ------
    FrictionloopError
        For an error or a force that is no number, or a negative force.
    """
    return np.asarray(np.abs(numbers("error_n", error_n, "N")) > friction_jnd_n(force_n))


def timing_felt(difference_s: ArrayLike) -> NDArray[np.bool_]:
    """Return whether two friction transitions that differ in duration by so much are told apart: more than 2.3 ms.

    Parameters
    ----------
    difference_s
        Differences in s, either sign, of any shape.

    Raises
    ------
    FrictionloopError
        For a difference that is no number.
    """
    return np.asarray(np.abs(numbers("difference_s", difference_s, "s")) > TIMING_JND_S)
