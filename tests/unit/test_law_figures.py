"""Figures of control laws: every law is told apart by its place, and what is unstable or cut off is said."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from frictionloop.design.comparison.law_figures import figure_residuals, figure_sensitivities, figure_step_traces
from frictionloop.design.response_figures import figure_step

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
    assert titles == [
        "before: as in the file: cut off, the force goes from 0.5 to 7 N",
        "after: as designed",
    ]
    assert all(0.75 < axes.get_ylim()[1] < 1.5 for axes in figure.axes)
