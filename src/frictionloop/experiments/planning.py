"""What a study needs: simulated participants, and studies drawn from them, by participants and by trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pandas  # type: ignore[import-untyped]
from scipy.stats import t as student

from frictionloop.experiments.participant import Observer
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.study import simulate_trials
from frictionloop.experiments.summary import fits, measure
from frictionloop.findings import Finding, Result
from frictionloop.findings.result import plain
from frictionloop.parameters import System
from frictionloop.quantities import must_be
from frictionloop.quantities.checks import Array

LEVEL = 0.05
"""Of the test."""
POOLS = 200
"""Pools that are drawn anew from the one that was simulated, for the interval (assumed)."""


@dataclass(frozen=True, kw_only=True)
class Power(Result):
    """Shares of studies that find a change."""

    SCHEMA: ClassVar[str] = "experiments.power/1"
    effect: float
    """Relative change of the participants' sense."""
    pool: int
    """Participants that were simulated."""
    shares: pandas.DataFrame
    """Columns condition, trials (0 is all), participants, power; low and high of its 95 % interval, by pools drawn
    anew from the participants that were simulated; without, those of them whose function could not be fitted."""

    def rows(self) -> list[tuple[str, str]]:
        """Return what the shares are of."""
        return [("power", f"share of studies that find a change of {100 * self.effect:g} %, p < {LEVEL:g}, %")]

    def tables(self) -> dict[str, pandas.DataFrame]:
        """Return power in percent by participants, trials and condition, with its 95 % interval."""
        names = list(dict.fromkeys(self.shares["condition"]))
        rows = []
        for (trials, people), some in self.shares.groupby(["trials", "participants"], sort=False):
            of = some.set_index("condition")
            row = {"participants": people, "trials": str(trials) if trials else "all"}
            for name in names:
                power, low, high = (100.0 * float(of.loc[name, key]) for key in ("power", "low", "high"))
                row |= {name: round(power), f"{name} 95 %": f"{low:.0f} to {high:.0f}"}
            rows.append(row)
        return {"power": pandas.DataFrame(rows).set_index("participants")}

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name, the shares as rows."""
        return super().to_dict() | {"shares": plain(self.shares.to_dict("records"))}


def power(
    protocol: Protocol,
    effect: float,
    participants: Sequence[int],
    system: System | None = None,
    *,
    trials: Sequence[int] | None = None,
    pool: int = 24,
    studies: int = 400,
    seed: int = 0,
    observer: Observer | None = None,
) -> Power:
    """Return the share of studies that find a change of the participants' sense, by condition, trials and participants.

    Each simulated participant takes part twice: as they are, and with all Weber fractions times 1 + effect. Studies of
    n are drawn from them with replacement; each has a paired t-test, two-sided, at 5 %. The same studies are drawn for
    each condition. A shorter study is the beginning of the long one: its first trials that counted.

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
    trials : sequence of int, optional
        Numbers of trials that count in a condition, each at least 5 and at most what the protocol gives; all if not
        given.
    pool : int
        Participants that are simulated.
    studies : int
        Studies drawn for each number.
    seed : int
        Seed of everything.
    observer : Observer, optional
        The participants as they are.

    Raises
    ------
    FrictionloopError
        For an effect or a number out of range.
    """
    if min(participants) < 2:
        raise must_be("participants", min(participants), "at least 2")
    rows = []
    again, changed = another_day(protocol, effect, observer)
    plans = [protocol, again]
    tables = [
        simulate_trials(plan, system, pool, seed, observer=own)
        for plan, own in zip(plans, (observer, changed), strict=True)
    ]
    for count in trials or [0]:
        pairs = differences(plans, [first_trials(table, count) for table in tables])
        for condition, change in pairs.items():
            known = change[np.isfinite(change)]
            for n in participants:
                found = shares(known, n, studies, seed)
                row = {"condition": condition, "trials": count, "participants": n, "power": found[0]}
                rows.append(row | {"low": found[1], "high": found[2], "without": change.size - known.size})
    found_all = pandas.DataFrame(rows)
    without = int(found_all["without"].max())
    more = {"measure": measure(protocol)[0], "reason": f"of {pool} participants at most"}
    unfitted = (Finding("STUDY-UNFITTED", value=without, more=more),) if without else ()
    return Power(effect=effect, pool=pool, shares=found_all, findings=unfitted)


def another_day(protocol: Protocol, effect: float, observer: Observer | None = None) -> tuple[Protocol, Observer]:
    """Return a protocol with other seeds, and an observer with all Weber fractions times 1 + effect.

    Raises
    ------
    FrictionloopError
        For an effect out of range.
    """
    if not effect > -1.0 or effect == 0.0:
        raise must_be("effect", effect, "above -1 and not 0")
    base = observer or Observer()
    webers = {name: getattr(base, name) for name in Observer.model_fields if name.endswith("weber")}
    changed = base.model_copy(update={name: value * (1.0 + effect) for name, value in webers.items()})
    return protocol.model_copy(update={"seed": protocol.seed + 1}), changed


def first_trials(trials: pandas.DataFrame, count: int) -> pandas.DataFrame:
    """Return of each participant and condition the first trials that counted; 0 is all.

    Raises
    ------
    FrictionloopError
        Where there are fewer.
    """
    counted = trials[trials["counted"] == 1]
    per = counted.groupby(["participant", "condition"])
    most = int(per.size().min()) if len(counted) else 0
    if count and not 5 <= count <= most:
        raise must_be("trials", count, f"5 to {most}")
    return per.head(count) if count else counted


def differences(plans: Sequence[Protocol], tables: Sequence[pandas.DataFrame]) -> dict[str, Array]:
    """Return by condition how much what is found of each participant has changed, NaN where it was not found."""
    one, two = (
        fits(plan, table, ("requested",)).set_index(["condition", "participant"])["value"]
        for plan, table in zip(plans, tables, strict=True)
    )
    change = two.reindex(one.index) - one
    return {name: change[name].to_numpy() for name in dict.fromkeys(one.index.get_level_values(0))}


def shares(change: Array, n: int, studies: int, seed: int) -> tuple[float, float, float]:
    """Return the share of studies of n that find a change, and its 95 % interval over pools of participants.

    Parameters
    ----------
    change : array
        Change of each participant of the pool.
    n : int
        Participants of a study.
    studies : int
        Studies that are drawn from a pool.
    seed : int
        Seed of what is drawn.
    """
    rng = np.random.default_rng([seed, 7, n])
    share = _found(change[rng.integers(0, change.size, (studies, n))])
    anew = [change[rng.integers(0, change.size, change.size)] for _ in range(POOLS)]
    others = [_found(pool[rng.integers(0, pool.size, (studies, n))]) for pool in anew]
    low, high = np.quantile(others, (0.025, 0.975))
    return share, float(low), float(high)


def _found(change: Array) -> float:
    """Return the share of studies, a row each, in which a paired t-test finds a change."""
    n = change.shape[1]
    spread = change.std(axis=1, ddof=1)
    # A draw of one participant alone has no spread, and shows nothing.
    t = np.divide(change.mean(axis=1) * np.sqrt(n), spread, out=np.zeros_like(spread), where=spread > 0.0)
    return float(np.mean(np.abs(t) > student.ppf(1.0 - 0.5 * LEVEL, n - 1)))
