"""What closing the loop saves: ratios by hand, and the tables that are shown are those of what is kept."""

from __future__ import annotations

import csv

import numpy as np
import pandas
import pytest

from studies import closing_saves, kept
from studies.closing_saves import PEOPLE, TRIALS, power, saved


def made(spread_open: float) -> pandas.DataFrame:
    """Return rows of participants with thresholds about 50 mN, of another spread in the open loop; +10 mN on day 2."""
    z = np.linspace(-1.0, 1.0, PEOPLE)
    rows = [
        (day, f"P{k:02d}", loop, trials, 0.05 + spread * z[k] + 0.01 * (day - 1) * (1 + 0.1 * z[k]))
        for day in (1, 2)
        for trials in TRIALS
        for loop, spread in (("closed", 0.01), ("open", spread_open))
        for k in range(PEOPLE)
    ]
    return pandas.DataFrame(rows, columns=("day", "participant", "loop", "trials", "threshold_n"))


def test_twice_the_spread_needs_four_times_the_participants_and_a_paired_test_does_not_see_it():
    found = made(0.02)
    for row in saved(found):
        assert row[3].startswith("4.0 (4.0 to 4.0)")
        assert row[4].startswith("4.0 (")
    assert {row[2:] for row in power(found)} == {("100 % (100 to 100)", "100 % (100 to 100)")}


def test_the_tables_are_those_of_the_rows_that_are_kept():
    rows = closing_saves.read()
    for name, made_of in (("closing-saves", saved), ("closing-power", power)):
        with (kept.RESULTS / f"{name}.csv").open(newline="", encoding="utf-8") as stream:
            _, *stored = csv.reader(line for line in stream if not line.startswith("#"))
        assert stored == [list(row) for row in made_of(rows)]


@pytest.mark.slow
def test_the_first_participants_are_found_again():
    """Two of them, after 20 trials: a shorter study is the beginning of the long one."""
    from frictionloop.experiments import fits, read_protocol
    from frictionloop.experiments.study_run import simulate_trials

    plan = read_protocol("study-friction").evolve({"stop.trials": TRIALS[0]})
    rows = closing_saves.read()
    one = rows[(rows["day"] == 1) & (rows["trials"] == TRIALS[0])].set_index(["participant", "loop"])["threshold_n"]
    trials = simulate_trials(plan, participants=2)
    first = trials[trials["block"] == 1]  # the trials of a later block are numbered, and so drawn, by those before
    for each in fits(plan, first, ("requested",)).itertuples():
        assert each.value == pytest.approx(one[each.participant, each.condition], abs=2e-3)
