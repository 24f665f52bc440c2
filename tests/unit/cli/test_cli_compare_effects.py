"""``frictionloop compare`` on effects: how much of a pattern arrives, for each law, and what is refused."""

from __future__ import annotations

import csv
from pathlib import Path

import frictionloop as fl
from frictionloop.design.comparison.effect_comparison import arrived, compare_effects
from frictionloop.design.comparison.trial_protocol import able, population

R = fl.rendering
WORDS = ("compare", "--fingers", "6", "--speeds", "80", "--laws", "lookup,retuned_pi")


def test_a_system_whose_set_point_is_an_effect_is_compared_on_it(frictionloop):
    bump = R.LIBRARY["bump"]
    mine = fl.bench().evolve({"setpoint.kind": "effect", "setpoint.effect": bump})
    fl.write_toml(mine, "mine.toml")
    found = frictionloop("compare", "mine.toml", *WORDS[1:], "--json", "--csv", "s.csv").json()["scores"]
    assert [(row["law"], row["effect"], row["speed_mm_s"]) for row in found] == [
        (law, "setpoint", 80.0) for law in ("lookup", "retuned_pi")
    ]
    opened, closed = found
    assert abs(closed["contrast"] - 1.0) < 0.1 < abs(opened["contrast"] - 1.0)
    assert closed["spread_n"] < 0.3 * opened["spread_n"]
    with Path("s.csv").open(newline="") as stream:
        kept = [float(row["contrast"]) for row in csv.DictReader(stream)]
    assert kept == [row["contrast"] for row in found]
    python = fl.compare_effects(mine, None, ["retuned_pi"], 6, speeds_mm_s=[80.0])
    assert python.scores == [closed] and python.best("setpoint") == "retuned_pi"
    assert python.table().loc["retuned_pi", "arrives, %"] == 100 * closed["contrast"]


def test_a_cell_is_of_the_capable_fingers_each_on_its_own_device():
    law = {"controller.kind": "limit_observer"}
    cell = arrived(fl.bench(), "grating", law, 80.0, 6, 11)
    people = population(fl.bench(), 6, 11)
    some = [each for each, counts in zip(people, able(fl.bench(), people, 80.0), strict=True) if counts]
    table = R.arrivals(["grating"], fl.bench(), some, (80.0,), laws={"limit_observer": law})
    assert cell["fingers"] == len(some)
    assert cell["spread_n"] == float(table.spread.squeeze())
    for name in ("contrast", "error_felt", "pattern_felt"):
        assert cell[name] == float(table[name].median())
    assert cell["contrast_low"] <= cell["contrast"] <= cell["contrast_high"]


def test_what_is_kept_is_not_run_again():
    kept, saved = {("lookup", "bump", 80.0): {"contrast": 7.0}}, []
    found = compare_effects(
        fl.bench(), ["bump"], ["lookup"], 6, speeds_mm_s=[80.0], kept=kept, save=lambda: saved.append(1)
    )
    assert (found.cells, saved) == ({("lookup", "bump", 80.0): {"contrast": 7.0}}, [])
