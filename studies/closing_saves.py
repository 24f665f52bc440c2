"""What closing the loop saves in an experiment on differences of friction: participants, and trials.

``python -m studies.closing_saves`` lets 96 simulated participants take part in ``study-friction``, and 48 of them on
another day with all Weber fractions a fifth larger. It keeps what each of them has after 20, 40 and 60 trials of each
loop, and what follows for *docs/experiments.md*. ``python -m studies.closing_saves again`` makes the tables anew.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas  # type: ignore[import-untyped]

from frictionloop.experiments import fits, read_protocol
from frictionloop.experiments.planning import another_day, first_trials, shares
from frictionloop.experiments.study_run import simulate_trials
from studies.kept import RESULTS, keep

PEOPLE, AGAIN, EFFECT, TRIALS, STUDIES = 96, 48, 0.2, (20, 40, 60), 400
SIZES = (12, 24, 40)
LOOPS = ("closed", "open")
CODES = [f"P{number:02d}" for number in range(1, PEOPLE + 1)]
DRAWN = 2000
"""Draws of participants with replacement, for intervals."""
OF = ["day", "loop", "trials"]
"""What a line of the kept file is of; it has a column for each participant."""


def people(plans: Sequence[Any], tables: Sequence[pandas.DataFrame]) -> Iterator[tuple[Any, ...]]:
    """Return a row for each day, loop and number of trials: the threshold of each participant, N."""
    for day, (plan, table) in enumerate(zip(plans, tables, strict=True), 1):
        for count in TRIALS:
            found = fits(plan, first_trials(table, count), ("requested",))
            for loop, some in found.groupby("condition", sort=False):
                own = dict(zip(some["participant"], some["value"], strict=True))
                yield day, loop, count, *(f"{own[name]:.5f}" if name in own else "" for name in CODES)


def read() -> pandas.DataFrame:
    """Return a row for each day, loop, number of trials and participant."""
    kept = pandas.read_csv(RESULTS / "closing-people.csv", comment="#")
    return kept.melt(OF, var_name="participant", value_name="threshold_n").dropna(ignore_index=True)


def saved(kept: pandas.DataFrame) -> list[tuple[str, ...]]:
    """Return what closing the loop saves by participants with a threshold in both, a row for each number of trials."""
    rows = []
    for count in TRIALS:
        some = kept[(kept["day"] == 1) & (kept["trials"] == count)]
        both = some.pivot(index="participant", columns="loop", values="threshold_n").dropna()
        drawn = np.random.default_rng(0).integers(0, len(both), (DRAWN, len(both)))
        own = [1e3 * both[loop].to_numpy() for loop in LOOPS]
        rows.append(
            (
                str(count),
                *(f"{each.mean():.0f} ± {each.std(ddof=1):.0f}" for each in own),
                _interval(own[1], own[0], drawn, lambda each: each.var(axis=-1, ddof=1)),
                _interval(own[1], own[0], drawn, lambda each: (each.std(axis=-1, ddof=1) / each.mean(axis=-1)) ** 2),
            )
        )
    return rows


def power(kept: pandas.DataFrame) -> list[tuple[str, ...]]:
    """Return the share of paired studies that find the change, a row for each number of trials and participants."""
    rows = []
    for count in TRIALS:
        some = kept[kept["trials"] == count]
        one, two = (some[some["day"] == day].set_index(["loop", "participant"])["threshold_n"] for day in (1, 2))
        change = (two - one).dropna()
        for n in SIZES:
            found = [shares(change[loop].to_numpy(), n, STUDIES, 0) for loop in LOOPS]
            rows.append(
                (str(count), str(n), *(f"{100 * a:.0f} % ({100 * b:.0f} to {100 * c:.0f})" for a, b, c in found))
            )
    return rows


def _interval(over: np.ndarray, under: np.ndarray, drawn: np.ndarray, of: Any) -> str:
    """Return a ratio and its 95 % interval over participants, the same of both loops."""
    ratio, others = of(over) / of(under), of(over[drawn]) / of(under[drawn])
    low, high = np.quantile(others, (0.025, 0.975))
    return f"{ratio:.1f} ({low:.1f} to {high:.1f})"


def write() -> None:
    """Keep the tables that follow from the rows."""
    kept = read()
    loops = [f"{loop}, mean ± SD (mN)" for loop in LOOPS]
    ratios = ("participants, same interval", "participants, same share")
    keep("closing-saves", "closing_saves", ("trials", *loops, *ratios), saved(kept))
    keep("closing-power", "closing_saves", ("trials", "participants", *LOOPS), power(kept))


def main() -> None:
    """Simulate, and keep."""
    plan = read_protocol("study-friction")
    again, changed = another_day(plan, EFFECT)
    tables = simulate_trials(plan, participants=PEOPLE), simulate_trials(again, participants=AGAIN, observer=changed)
    keep("closing-people", "closing_saves", [*OF, *CODES], people((plan, again), tables))
    write()


if __name__ == "__main__":
    write() if sys.argv[1:] == ["again"] else main()
