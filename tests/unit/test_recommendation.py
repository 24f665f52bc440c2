"""Which law a comparison recommends, what decides it, and figures in which every law is told apart."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

from frictionloop.design.comparison.law_comparison import recommended
from frictionloop.design.comparison.law_figures import figure_residuals, figure_sensitivities, figure_step_traces
from frictionloop.design.response_figures import figure_step
from frictionloop.findings import Condition

PLACE = Condition(slip_length_um=(0.0,), speed_mm_s=(20.0,))


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


def told(found):
    """Return the findings by code."""
    return {each.code: each for each in found}


def test_the_default_law_is_recommended_while_another_is_better_by_less_than_fingers_differ():
    worst = {"notch_pi": 0.036, "hinf": 0.026, "retuned_pi": 0.010, "lookup": 0.001}
    law, found = recommended(*rows_of(worst, ["retuned_pi"]))
    (close,) = found
    assert (law, close.code, close.more["law"]) == ("notch_pi", "LAW-CLOSE", "hinf")
    assert (close.value, close.limit, close.more["apart"]) == pytest.approx((26, 36, 18))


@pytest.mark.parametrize(("felt", "rougher"), [(1.2, False), (2.4, True)])
def test_a_law_that_is_rougher_to_touch_than_another_says_so(felt, rougher):
    rows, margins = rows_of({"notch_pi": 0.036, "retuned_pi": 0.040})
    at = {"score": "relative_index", "speed_mm_s": 20.0, "population": "capable", "fingers": 12, "worst_decile": 9.0}
    rows += [
        {"law": law, "slip_length_um": length_um, "median": value} | at
        for law, value in (("notch_pi", felt), ("retuned_pi", 1.1))
        for length_um in (11.5, 0.0)
    ]
    law, found = recommended(rows, margins)
    assert law == "notch_pi" and ("LAW-ROUGHER" in told(found)) == rougher
    if rougher:
        one = told(found)["LAW-ROUGHER"]
        assert (one.value, one.limit, one.more) == (2.4, 1.1, {"law": "retuned_pi"})


def test_another_law_is_recommended_where_it_is_clearly_better():
    law, found = recommended(*rows_of({"notch_pi": 0.036, "hinf": 0.012}))
    close = told(found)["LAW-CLOSE"]
    assert (law, close.more["law"], close.value) == ("hinf", "notch_pi", pytest.approx(36))


def test_another_law_is_recommended_where_the_default_is_not_stable():
    law, found = recommended(*rows_of({"notch_pi": 0.036, "hinf": 0.040}, ["notch_pi"]))
    one = told(found)["LAW-UNSTABLE"]
    assert (law, one.more, one.limit, one.where) == ("hinf", {"law": "notch_pi"}, 5, PLACE)


def test_what_the_recommended_law_does_not_bear_is_said():
    law, found = recommended(*rows_of({"notch_pi": 0.02, "hinf": 0.025, "mine": 0.026}, [], ["notch_pi"]))
    one = told(found)["LAW-UNSTABLE"]
    assert (law, one.more, one.limit, one.where) == ("notch_pi", {"law": "notch_pi"}, 10, PLACE)


@pytest.mark.parametrize("peak", [math.inf, math.nan])
def test_no_law_is_recommended_that_is_not_known_to_be_stable(peak):
    rows, margins = rows_of({"notch_pi": 0.036, "printed_pi": 0.01})
    margins[0]["sensitivity_peak_5"] = peak
    law, found = recommended(rows, margins)
    assert law is None and [each.code for each in found] == ["LAW-UNSTABLE"]


def test_a_law_whose_margins_nobody_knows_is_not_recommended():
    rows, margins = rows_of({"notch_pi": 0.036, "limit_observer": 0.005})
    assert recommended(rows, [row for row in margins if row["law"] != "limit_observer"])[0] == "notch_pi"


@pytest.mark.parametrize(("capable", "more"), [(9, "--fingers 40"), (1, "--fingers 300"), (0, "")])
def test_too_few_capable_fingers_decide_nothing(capable, more):
    rows, margins = rows_of({"notch_pi": 0.036, "hinf": 0.012}, ["notch_pi", "hinf"], capable=capable)
    law, (one,) = recommended(rows, margins)
    assert (law, one.code, one.value, one.remedy) == (None, "COMPARE-FEW", capable, more)


def test_where_the_default_does_not_bear_the_largest_gain_the_best_that_does_is_recommended():
    rows, margins = rows_of({"notch_pi": 0.030, "limit_observer": 0.032, "hinf": 0.028})
    loud = {"notch_pi": 134.0, "limit_observer": 2.46, "hinf": 7.1}
    margins = [row | {"sensitivity_peak_gain": 2.0, "sensitivity_peak_gain_low": loud[row["law"]]} for row in margins]
    law, found = recommended(rows, margins)
    one = told(found)["LAW-LOUD"]
    assert (law, one.value, one.limit, one.more["law"]) == ("limit_observer", 134.0, 4.0, "notch_pi")


LENGTHS_UM = [11.5, 0.0]
TIME = np.arange(0.0, 2.0, 1e-3)


def words(figure):
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def steps(**largest_n):
    """Traces that rest at 0.5 N but for one reading of each law."""
    force = np.full((len(largest_n), len(LENGTHS_UM), TIME.size), 0.5)
    force[:, 0, 1510] = list(largest_n.values())  # 10 ms after the step up
    dims, there = ("law", "slip_length_um", "time"), {"law": list(largest_n), "contact": LENGTHS_UM, "time": TIME}
    return xr.Dataset({"f_a": (dims, force), "f_r": (dims, np.full_like(force, 0.5))}, there)


def test_a_law_that_is_unstable_is_said_to_be():
    frequency_hz = np.geomspace(1.0, 2500.0, 50)
    size = np.full(50, 0.5)
    found = {("a", 11.5): size, ("a", 0.0): size, ("b", 11.5): size, ("b", 0.0): None}
    found |= {("c", length_um): None for length_um in LENGTHS_UM}
    figure = figure_sensitivities(frequency_hz, found, ["a", "b", "c", "oracle"], 20.0)
    said = {axes.get_title("left"): [text.get_text() for text in axes.texts] for axes in figure.axes}
    assert said == {"a": [], "b": ["unstable at 0 um"], "c": ["unstable"]}


def test_a_force_that_leaves_the_panel_is_said_to():
    figure = figure_step_traces(steps(calm=0.6, wild=3.0), 20.0)
    # Rows are laws, columns contacts and steps; the force leaves on the first contact's step up only.
    assert words(figure) == ["cut off, reaches 3 N"]
    assert [bool(axes.texts) for axes in figure.axes] == [False] * 5 + [True, False, False]
    assert [axes.get_ylabel() for axes in figure.axes[::4]] == ["calm", "wild"]
    assert all(axes.get_ylim()[1] < 1.2 for axes in figure.axes)


def test_a_force_that_falls_out_of_the_panel_is_said_to():
    assert words(figure_step_traces(steps(calm=0.1, pulled=-0.4), 20.0)) == ["cut off, reaches -0.4 N"]


@pytest.mark.parametrize("order", [("oracle", "law"), ("law", "oracle")], ids=str)
def test_the_oracle_is_beside_every_other_law(order):
    figure = figure_step_traces(steps(**dict.fromkeys(order, 0.5)), 20.0)
    assert sorted({len(axes.lines) for axes in figure.axes}) == [2, 3]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["oracle", "set-point", "this law"]


def test_residuals_have_a_row_and_two_numbers_for_each_law():
    # 1 to 10 mN: half the fingers are below 5.5 mN, nine in ten at 9 mN or below.
    residual = np.stack([1e-3 * np.arange(1.0, 11.0), np.full(10, np.nan)])[:, None, None, :]
    dims = ("law", "speed_mm_s", "slip_length_um", "finger")
    scored = xr.Dataset(
        {"residual_rms_n": (dims, residual), "capable": (("speed_mm_s", "finger"), np.full((1, 10), True))},
        {"law": ["some", "none"], "speed_mm_s": [20.0], "slip_length_um": [11.5]},
    )
    figure = figure_residuals(scored)
    assert words(figure) == ["5.5, 9"]
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == ["some", "none"]


def test_the_step_before_does_not_flatten_the_step_after():
    after, before = (steps(law=largest).isel(law=0, slip_length_um=0) for largest in (0.8, 7.0))
    figure = figure_step(before, after, "as asked")
    titles = [axes.get_title("left") for axes in figure.axes]
    assert titles == ["before: as in the file: cut off, the force goes from 0.5 to 7 N", "after: as designed"]
    assert all(0.75 < axes.get_ylim()[1] < 1.5 for axes in figure.axes)
