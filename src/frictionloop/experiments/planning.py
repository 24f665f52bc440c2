"""Before a study: a protocol run dry, how long it takes, whom it suits, how many participants and trials it needs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas  # type: ignore[import-untyped]
from scipy.stats import t as student

from frictionloop.experiments.levels_within_reach import Needed, in_reach, needed
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.simulated_participant import Observer
from frictionloop.experiments.study_run import simulate_trials, study_system
from frictionloop.experiments.study_summary import fits, measure
from frictionloop.experiments.trial_records import scored
from frictionloop.experiments.trial_sequence import TrialOrder
from frictionloop.findings import Finding, Result
from frictionloop.findings.result import plain
from frictionloop.findings.shown import between
from frictionloop.parameters import System
from frictionloop.parameters.motion import Strokes
from frictionloop.physics.fingers import fingers
from frictionloop.quantities import Array, FrictionloopError, must_be
from frictionloop.rendering.effect import Track
from frictionloop.rendering.effect_player import program_of

MOST_TRIALS = 20_000
"""Trials of a dry run, after which a protocol is taken to have no end (assumed)."""
ANSWER_S = 1.0
"""Time that an answer is counted with (assumed)."""
FEW = 0.25
"""Share of fingers in reach below which that is a finding (assumed)."""
PEOPLE = 200
"""Fingers that the share in reach is told of (assumed)."""


class ProtocolCheck(Result, schema="experiments.check/1"):
    """What a protocol will do."""

    name: str
    title: str
    trials: tuple[int, int]
    """Trials of a session whose answers are all right, and all wrong; of one whose answers are numbers the same."""
    duration_s: float
    """Longest time of these, an answer counted with 1 s, without breaks and repetitions."""
    needed: Needed
    """Forces that it asks for."""
    share_in_reach: float
    """Share of the population's fingers that can be given all of them."""

    def rows(self) -> list[tuple[str, str]]:
        """Return trials, time, forces and the share of fingers."""
        fewest, most = sorted(self.trials)
        return [
            ("protocol", f"{self.name}: {self.title}"),
            ("trials", between(float(fewest), float(most))),
            ("takes", f"{self.duration_s / 60.0:.0f} min at most, without breaks"),
            ("forces", between(self.needed.low_n, self.needed.high_n, "N")),
            ("in reach", f"of {100 * self.share_in_reach:.0f} % of fingers"),
        ]


def check(protocol: Protocol, system: System | None = None) -> ProtocolCheck:
    """Run every branch of a protocol dry and return what it will do.

    Parameters
    ----------
    protocol : Protocol
        What is to be checked.
    system : System, optional
        The bench that it is to run on; that of `study_system` if not given.

    Raises
    ------
    FrictionloopError
        For a field of the system or the effect that is not there, an effect that does not fit the plate, a stroke that
        is longer than the plate, forces that no finger can be given, or a protocol without an end; naming field and
        trial.
    """
    base = (system or study_system()).evolve(protocol.system)
    for condition in protocol.conditions:
        try:
            own = base.evolve(condition.system)
        except FrictionloopError as error:
            raise FrictionloopError(f"conditions.{condition.name}.system: {error}") from None
        _fits(protocol, own)
        for level in {*protocol.method.extremes()}:
            try:
                program_of(protocol.stimulus.at(level, condition.effect), Track(), own.touch.load.length_mm)
            except FrictionloopError as error:
                raise FrictionloopError(f"condition {condition.name}, level {level:g}: {error}") from None
    runs = [_dry(protocol, right) for right in (True, False)]
    wanted = needed(protocol)
    share = float(np.mean([in_reach(protocol, finger, base) for finger in fingers(PEOPLE, 0)]))
    if share == 0.0:
        raise FrictionloopError(f"forces = {between(*wanted[:2], 'N')}: in reach of none of {PEOPLE} fingers")
    few = [Finding("STUDY-REACH", value=100.0 * share, unit="%")] if share < FEW else []
    return ProtocolCheck(
        name=protocol.name,
        title=protocol.title,
        trials=(runs[0][0], runs[1][0]),
        duration_s=max(each[1] for each in runs),
        needed=wanted,
        share_in_reach=share,
        findings=tuple(few),
    )


def _fits(protocol: Protocol, system: System) -> None:
    guide = protocol.timeline.stroke
    if not isinstance(system.motion, Strokes):
        raise FrictionloopError('motion.kind: must be "strokes"')
    if guide.length_mm > system.touch.load.length_mm:
        raise FrictionloopError(
            f"timeline.stroke.length_mm = {guide.length_mm:g}: the plate has {system.touch.load.length_mm:g} mm"
        )


def _dry(protocol: Protocol, right: bool) -> tuple[int, float]:
    """Return how many trials a session has whose answers are all right or all wrong, and how long it takes."""
    order, line = TrialOrder(protocol, "P01"), protocol.timeline
    trial_s = (
        line.cue_s + protocol.intervals * line.stroke.duration_s + (protocol.intervals - 1) * line.gap_s + ANSWER_S
    )
    number = 0
    while (trial := order.next()) is not None:
        number += 1
        if number > MOST_TRIALS:
            raise must_be("stop.trials", protocol.stop.trials, f"at most {MOST_TRIALS}")
        protocol.stimulus.at(trial.level, trial.condition.effect)
        answer = _answer(protocol, trial.level, trial.comparison, right)
        _, result = scored(protocol, trial.level, trial.comparison, answer)
        start = (number - 1) * trial_s
        order.tell(
            {
                "phase": trial.phase,
                "again": 0,
                "counted": int(trial.phase == "main"),
                "result": result,
                "delivered": trial.level,
                "onset_s": start,
                "offset_s": start + trial_s,
            }
        )
    return number, number * trial_s


def _answer(protocol: Protocol, level: float, comparison: int, right: bool) -> str:
    if not protocol.choices:
        return "50"
    if protocol.task == "adjustment":
        return "alike" if right else "more"
    found = {scored(protocol, level, comparison, each)[0]: each for each in protocol.choices}
    return found.get(1.0 if right else 0.0, protocol.choices[0])


LEVEL = 0.05
"""Of the test."""
POOLS = 200
"""Pools that are drawn anew from the one that was simulated, for the interval (assumed)."""


class Power(Result, schema="experiments.power/1"):
    """Shares of studies that find a change."""

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
        For an effect or a number out of range, or a pool of whom nothing is found.
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
            if not known.size:
                raise FrictionloopError(f"power: no {measure(protocol)[0]} of {pool} participants in {condition}")
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
    """Return a protocol with other seeds, and an observer with all Weber fractions times 1 + effect."""
    if not effect > -1.0 or effect == 0.0:
        raise must_be("effect", effect, "above -1 and not 0")
    base = observer or Observer()
    webers = {name: getattr(base, name) for name in Observer.model_fields if name.endswith("weber")}
    changed = base.model_copy(update={name: value * (1.0 + effect) for name, value in webers.items()})
    return protocol.model_copy(update={"seed": protocol.seed + 1}), changed


def first_trials(trials: pandas.DataFrame, count: int) -> pandas.DataFrame:
    """Return of each participant and condition the first trials that counted; 0 is all."""
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
    """Return the share of studies of n that find a change, and its 95 % interval over pools of participants."""
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
