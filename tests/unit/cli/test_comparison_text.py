"""The tables of a comparison fit a terminal of 80 columns."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from frictionloop.cli import screen
from frictionloop.cli.comparison_text import SHOWN, _scores, recommendation, short
from frictionloop.design.comparison import ENTRANTS


@pytest.mark.parametrize(
    "value, text",
    [
        (0.9925, ".993"),
        (0.848, "0.85"),
        (6.667, "6.7"),
        (9.96, "10"),
        (613.4, "613"),
        (-48.12, "-48"),
        (0.004567, "0.0046"),
        (-9999.0, "-9999"),
        (math.inf, "∞"),
        (-math.inf, "-∞"),
        (0.0, "0"),
    ],
)
def test_a_score_in_two_digits(value, text):
    assert short(value) == text


def test_all_laws_fit_80_columns_to_the_last_score(capsys, monkeypatch):
    """Cells about as long as they get: an R2 of thousands below 0, times of 100 ms, and 613 times an oracle's rms."""
    monkeypatch.setenv("COLUMNS", "80")
    long = {
        "r2_identity": (-0.4567, -9876.5),
        "residual_rms_n": (0.61349, 0.98765),
        "fall_63_s": (0.012345, 0.1134),
        "relative_index": (0.01234, 118.2),
        "over_oracle": (613.4, 11234.5),
    }
    assert list(long) == [name for name, _, _ in SHOWN]
    rows = [
        {"law": law, "score": name, "median": median, "worst_decile": worst}
        for law in ENTRANTS
        for name, (median, worst) in long.items()
    ]
    screen.show(screen.table(_scores(SimpleNamespace(laws=ENTRANTS), rows, {})))
    heads, *lines = capsys.readouterr().out.splitlines()
    assert heads.split()[-1] == "/oracle"
    assert [line.split()[0] for line in lines] == list(ENTRANTS)
    assert all(line.split()[1:] == ["-0.46/-9876", "613/988", "12/113", "0.012/118", "613/11234"] for line in lines)
    assert max(map(len, (heads, *lines))) <= 80


def rows_of(worst, stable, capable=3):
    """Return rows of residuals in N and of margins, for laws at one speed and contact."""
    rows = [
        {"law": law, "score": "residual_rms_n", "speed_mm_s": 20.0, "contact": "dahl", "population": population}
        | {"fingers": count, "median": 0.5 * value, "worst_decile": value * factor}
        for law, value in worst.items()
        for population, count, factor in (("all", 9, 10.0), ("capable", capable, 1.0))
    ]
    return rows, [{"law": law, "stable": stable.get(law, True)} for law in worst]


def test_the_stable_law_that_leaves_the_least_is_recommended():
    worst = {"notch_pi": 0.036, "hinf": 0.026, "retuned_pi": 0.020, "tracker": 0.01, "oracle": 0.001}
    said = recommendation(*rows_of(worst, {"retuned_pi": False}))
    assert said.startswith("Recommended: hinf. ") and "26 mN in the worst decile" in said
    assert "260 mN" in recommendation(*rows_of(worst, {"retuned_pi": False}, capable=0))


@pytest.mark.parametrize("stable", [False, None])
def test_no_law_is_recommended_that_is_not_known_to_be_stable(stable):
    said = recommendation(*rows_of({"notch_pi": 0.036, "tracker": 0.01}, {"notch_pi": stable}))
    assert said.startswith("Recommended: none of these laws")
