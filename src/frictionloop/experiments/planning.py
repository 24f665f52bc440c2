"""How many participants a study needs: simulated participants, and studies drawn from them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas  # type: ignore[import-untyped]
from scipy.stats import ttest_rel

from frictionloop.experiments.participant import Observer
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.study import simulate
from frictionloop.experiments.summary import fits
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError

LEVEL = 0.05
"""Of the test."""


def power(
    protocol: Protocol,
    effect: float,
    participants: Sequence[int],
    system: System | None = None,
    *,
    pool: int = 24,
    studies: int = 400,
    seed: int = 0,
    observer: Observer | None = None,
) -> pandas.DataFrame:
    """Return the share of studies that find a change of the participants' sense, by condition and their number.

    Each simulated participant takes part twice: as they are, and with all Weber fractions times 1 + effect. Studies of
    n are drawn from them with replacement; each has a paired t-test, two-sided, at 5 %.

    Parameters
    ----------
    protocol : Protocol
        What is asked; each of its conditions is told by itself, so that open and closed loop stand side by side.
    effect : float
        Relative change, such as 0.2, above -1 and not 0.
    participants : sequence of int
        Numbers of participants, each at least 2.
    system : System, optional
        The bench.
    pool : int
        Participants that are simulated.
    studies : int
        Studies drawn for each number.
    seed : int
        Seed of everything.
    observer : Observer, optional
        The participants as they are.

    Returns
    -------
    pandas.DataFrame
        Columns condition, participants, power, and low and high of its 95 % interval by the studies' number alone.

    Raises
    ------
    FrictionloopError
        For an effect or a number out of range.
    """
    if not effect > -1.0 or effect == 0.0:
        raise FrictionloopError(f"effect = {effect:g}: must be above -1 and not 0, such as 0.2")
    if min(participants) < 2:
        raise FrictionloopError(f"participants = {min(participants)}: must be at least 2")
    base = observer or Observer()
    changed = base.model_copy(
        update={name: getattr(base, name) * (1.0 + effect) for name in Observer.model_fields if name.endswith("weber")}
    )
    found = []
    # The second time is another day: other seeds of the same fingers.
    again = protocol.model_copy(update={"seed": protocol.seed + 1})
    for plan, own in ((protocol, base), (again, changed)):
        trials = simulate(plan, system, pool, seed, observer=own)
        fitted = fits(plan, trials, ("requested",))
        found.append(fitted.set_index(["condition", "participant"])["value"])
    rng, rows = np.random.default_rng([seed, 7]), []
    for condition in dict.fromkeys(found[0].index.get_level_values(0)):
        pairs = np.column_stack([each[condition].to_numpy() for each in found])
        pairs = pairs[np.isfinite(pairs).all(axis=1)]
        rows += [_row(condition, n, pairs, studies, rng) for n in participants]
    return pandas.DataFrame(rows)


def _row(condition: str, n: int, pairs: Any, studies: int, rng: np.random.Generator) -> dict[str, Any]:
    some = pairs[rng.integers(0, len(pairs), (studies, n))]
    # A draw of one participant alone has no spread, and shows nothing.
    known = np.ptp(some[:, :, 1] - some[:, :, 0], axis=1) > 0
    p = np.ones(studies)
    p[known] = ttest_rel(some[known, :, 1], some[known, :, 0], axis=1).pvalue
    share = float(np.mean(p < LEVEL))
    half = 1.96 * float(np.sqrt(max(share * (1 - share), 1.0 / studies) / studies))
    low, high = max(share - half, 0.0), min(share + half, 1.0)
    return {"condition": condition, "participants": n, "power": share, "low": low, "high": high}
