"""How right thresholds of 60 trials are: bias, and how often the 95 % interval holds, beside psignifit 4.

``python -m studies.threshold_coverage [SESSIONS [OF_PSIGNIFIT]]`` simulates sessions of a staircase, psi and constant
stimuli, and fits each. Observers answer by a function of the family that is fitted, g + (1 - g - l) Phi((x - a)/b) with
g = 1/2, or by signal detection, (1 - l) Phi(z(3/4) x/a) + l/2: 1/2 at level 0, and never steep.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from scipy.special import ndtr

from frictionloop.experiments import fit, read_protocol
from frictionloop.experiments.method_kinds import ConstantMethod, MethodModel
from frictionloop.experiments.psychometric import JND_Z, probability
from frictionloop.experiments.trial_structure import Stop
from frictionloop.quantities import FrictionloopError
from studies.kept import keep

TRIALS, MOST = 60, 0.2
"""Trials of a session, and largest level, N: that of jnd-friction-staircase and study-friction."""
METHODS: dict[str, MethodModel] = {
    "staircase": read_protocol("jnd-friction-staircase").method,
    "psi": read_protocol("study-friction").method,
    "constant": ConstantMethod(levels=tuple(np.linspace(MOST / 6, MOST, 6).tolist()), repeats=TRIALS // 6),
}
INNER = (0.2, 0.8)
"""Part of the range from which most observers are drawn: the outer fifths leave levels on one side alone."""
COMPARED = f"{INNER[0]:g} to {INNER[1]:g} of the range"
HEADS = (
    "thresholds", "method", "sessions", "without", "bias, %", "holds, %",
    "of psignifit: sessions", "bias of psignifit, %", "psignifit holds, %", "width over psignifit's",
    "without level 0",
)  # fmt: skip


class Observer(NamedTuple):
    """Threshold and spread, N, and lapse rate of who answers; without a spread by signal detection."""

    threshold: float
    spread: float
    lapse: float

    def right(self, level: float) -> float:
        """Return how probable a right answer is."""
        if self.spread:
            return float(probability(level, self.threshold, self.spread, 0.5, self.lapse))
        return 0.5 * self.lapse + (1.0 - self.lapse) * float(ndtr(JND_Z * level / self.threshold))


def observers(part: tuple[float, float], ends: tuple[float, float], seed: int) -> Observer:
    """Return one with a threshold in a part of the range, a spread of 0.2 to 1 of it, lapses up to 6 % (assumed)."""
    rng = np.random.default_rng([seed, 7])
    threshold = ends[0] + (ends[1] - ends[0]) * rng.uniform(*part)
    return Observer(threshold, threshold * math.exp(rng.uniform(math.log(0.2), 0.0)), rng.uniform(0.0, 0.06))


DRAWN: dict[str, Callable[[tuple[float, float], int], Observer]] = {
    COMPARED: lambda ends, seed: observers(INNER, ends, seed),
    f"{COMPARED}, signal detection": lambda ends, seed: observers(INNER, ends, seed)._replace(spread=0.0),
    "the whole range": lambda ends, seed: observers((0.0, 1.0), ends, seed),
}


def session(method: MethodModel, who: Observer, seed: int) -> Trials:
    """Return levels and results of a session of 60 trials."""
    handler, rng = method.handler(seed, Stop(trials=TRIALS), 0.5), np.random.default_rng([seed, 8])
    while len(handler.told) < TRIALS:
        handler.add_response(rng.random() < who.right(handler.level))
    return np.array([each.asked for each in handler.told]), np.array([each.result for each in handler.told])


Trials = tuple[np.ndarray, np.ndarray]


def ours(trials: Trials, ends: tuple[float, float], low: float | None = 0.0) -> tuple[float, float, float]:
    """Return threshold and interval of `fit`, as a report has them; NaN where it finds none."""
    try:
        return fit(*trials, 0.5, low=low, ends=ends)[:3]
    except FrictionloopError:
        return math.nan, math.nan, math.nan


def theirs(trials: Trials, ends: tuple[float, float]) -> tuple[float, float, float]:
    """Return those of psignifit, told the same stimulus range: its estimate is the mode."""
    import psignifit  # type: ignore[import-untyped]

    level, result = trials
    values, where = np.unique(level, return_inverse=True)
    data = np.column_stack([values, np.bincount(where, result), np.bincount(where)])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = psignifit.psignifit(data, experiment_type="2AFC", stimulus_range=ends)
    return found.parameter_estimate["threshold"], *found.confidence_intervals["threshold"]["0.95"]


def told(found: np.ndarray, true: np.ndarray) -> tuple[float, float]:
    """Return mean relative error and share of intervals that hold, in percent, of rows of value, low and high."""
    known = np.isfinite(found[:, 0])
    (value, low, high), a = found[known].T, true[known]
    return 100.0 * float(np.mean(value / a - 1.0)), 100.0 * float(np.mean((low <= a) & (a <= high)))


def rows(sessions: int, compared: int) -> Iterator[list[Any]]:
    """Yield a row of each kind of observers and each method."""
    for drawn, who in DRAWN.items():
        for name, method in METHODS.items():
            ends = method.extremes()
            people = [who(ends, seed) for seed in range(sessions)]
            trials = [session(method, each, seed) for seed, each in enumerate(people)]
            true, found = np.array([each.threshold for each in people]), np.array([ours(each, ends) for each in trials])
            row = [
                drawn,
                name,
                sessions,
                int(np.isnan(found[:, 0]).sum()),
                *(f"{each:.1f}" for each in told(found, true)),
            ]
            if drawn != COMPARED or not compared:
                yield [*row, "", "", "", "", ""]
                continue
            other = np.array([theirs(each, ends) for each in trials[:compared]])
            alike = np.array([ours(each, ends, None) for each in trials[:compared]])
            wider = [np.diff(each[:compared, 1:]) / np.diff(other[:, 1:]) for each in (found, alike)]
            beside = (f"{each:.1f}" for each in told(other, true[:compared]))
            yield [*row, compared, *beside, *(f"{np.nanmedian(each):.2f}" for each in wider)]


def main(sessions: str = "1000", compared: str = "100") -> None:
    """Write the table."""
    keep("threshold-coverage", "threshold_coverage", HEADS, rows(int(sessions), int(compared)))


if __name__ == "__main__":
    main(*sys.argv[1:])
