"""The tables of a comparison fit a terminal of 80 columns."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from frictionloop.cli import screen
from frictionloop.cli.comparison_advice import recommendation
from frictionloop.cli.comparison_text import SHOWN, _scores, short
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
    """Cells about as long as they get: a hold of a loop that rings, and times of 100 ms."""
    monkeypatch.setenv("COLUMNS", "80")
    long = {
        "residual_rms_n": (0.61349, 0.98765),
        "hold_rms_n": (0.61349, 9.8765),
        "turn_peak_n": (1.2345, 1.987),
        "fall_63_s": (0.012345, 0.1134),
        "relative_index": (0.01234, 118.2),
    }
    assert list(long) == [name for name, _, _ in SHOWN]
    rows = [
        {"law": law, "score": name, "median": median, "worst_decile": worst}
        for law in ENTRANTS
        for name, (median, worst) in long.items()
    ]
    screen.show(screen.table(_scores(SimpleNamespace(laws=ENTRANTS), rows, {})))
    heads, *lines = capsys.readouterr().out.splitlines()
    assert heads.split()[-1] == "felt"
    assert [line.split()[0] for line in lines] == list(ENTRANTS)
    assert all(line.split()[1:] == ["613/988", "613/9876", "1.2/2", "12/113", "0.012/118"] for line in lines)
    assert max(map(len, (heads, *lines))) <= 80


def rows_of(worst, unstable_5=(), unstable_10=(), capable=12):
    """Return rows of residuals in N and of margins, for laws at one speed and contact; the median is half the worst."""
    rows = [
        {"law": law, "score": "residual_rms_n", "speed_mm_s": 20.0, "slip_length_um": 0.0, "population": population}
        | {"fingers": count, "median": 0.5 * value * factor, "worst_decile": value * factor}
        for law, value in worst.items()
        for population, count, factor in (("all", 30, 10.0), ("capable", capable, 1.0))
    ]
    off_5, off_10 = dict.fromkeys(unstable_5, math.inf), dict.fromkeys(unstable_10, math.inf)
    margins = [
        {"law": law, "speed_mm_s": 20.0, "slip_length_um": 0.0}
        | {"sensitivity_peak_5": off_5.get(law, 1.7), "sensitivity_peak_10": (off_10 | off_5).get(law, 2.0)}
        for law in worst
    ]
    return rows, margins


def test_the_default_law_is_recommended_while_another_is_better_by_less_than_fingers_differ():
    worst = {"notch_pi": 0.036, "hinf": 0.026, "retuned_pi": 0.010, "lookup": 0.001}
    said = recommendation(*rows_of(worst, ["retuned_pi"]))
    assert said == (
        "Recommended: notch_pi. It leaves 36 mN in the worst decile of fingers, speeds and slip lengths. "
        "hinf leaves less, "
        "26 mN. That differs by no more than fingers do: 18 mN from their median."
    )


@pytest.mark.parametrize(("felt", "told"), [(1.2, False), (2.4, True)])
def test_a_law_that_is_rougher_to_touch_than_another_says_so(felt, told):
    rows, margins = rows_of({"notch_pi": 0.036, "retuned_pi": 0.040})
    rows += [
        {
            "law": law,
            "score": "relative_index",
            "speed_mm_s": 20.0,
            "slip_length_um": length_um,
            "population": "capable",
        }
        | {"fingers": 12, "median": value, "worst_decile": 9.0}
        for law, value in (("notch_pi", felt), ("retuned_pi", 1.1))
        for length_um in (11.5, 0.0)
    ]
    said = recommendation(rows, margins)
    assert said.startswith("Recommended: notch_pi.")
    assert ("rougher than retuned_pi: felt is 2.4 and not 1.1, so try both" in said) == told


def test_another_law_is_recommended_where_it_is_clearly_better():
    said = recommendation(*rows_of({"notch_pi": 0.036, "hinf": 0.012}))
    assert said.startswith("Recommended: hinf. It leaves 12 mN in the worst decile")
    assert "notch_pi leaves more, 36 mN. That differs by more than fingers do: 18 mN" in said


def test_another_law_is_recommended_where_the_default_is_not_stable():
    said = recommendation(*rows_of({"notch_pi": 0.036, "hinf": 0.040}, ["notch_pi"]))
    assert said.startswith("Recommended: hinf. It leaves 40 mN")
    assert said.endswith("notch_pi is not known to be stable with the resonance 5 % off: slip length 0 um at 20 mm/s.")


def test_what_the_recommended_law_does_not_bear_is_said():
    said = recommendation(*rows_of({"notch_pi": 0.02, "hinf": 0.025, "mine": 0.026}, [], ["notch_pi"]))
    assert said.startswith("Recommended: notch_pi. ")
    assert (
        "With the resonance 10 % off it is not stable everywhere: slip length 0 um at 20 mm/s. "
        "Stable there: hinf and mine." in said
    )
    said = recommendation(*rows_of({"notch_pi": 0.02}, [], ["notch_pi"]))
    assert said.endswith("Stable there: none of these laws.")


@pytest.mark.parametrize("peak", [math.inf, math.nan])
def test_no_law_is_recommended_that_is_not_known_to_be_stable(peak):
    rows, margins = rows_of({"notch_pi": 0.036, "printed_pi": 0.01})
    margins[0]["sensitivity_peak_5"] = peak
    assert recommendation(rows, margins).startswith("Recommended: none of these laws. None of these laws is known")


def test_a_law_whose_margins_nobody_knows_is_not_recommended():
    rows, margins = rows_of({"notch_pi": 0.036, "limit_observer": 0.005})
    known = [row for row in margins if row["law"] != "limit_observer"]
    assert recommendation(rows, known).startswith("Recommended: notch_pi.")


@pytest.mark.parametrize(("capable", "more"), [(9, "--fingers 40 "), (1, "--fingers 300 "), (0, "_um gives more")])
def test_too_few_capable_fingers_decide_nothing(capable, more):
    said = recommendation(*rows_of({"notch_pi": 0.036, "hinf": 0.012}, ["notch_pi", "hinf"], capable=capable))
    assert said.startswith(f"Recommended: none of these laws. Of 30 fingers only {capable} at 20 mm/s")
    assert "fewer than 10 decide nothing" in said and more in said and "stable" not in said
