"""The study that comes with the report: complete, and what is not finite is read as it was written."""

from __future__ import annotations

import numpy as np
import pytest

from frictionloop.control.instruction_cost import worst_tick
from frictionloop.design.comparison.law_figures import figure_step_traces
from frictionloop.report.control_law_study import (
    LAWS,
    NOTCH,
    OPEN,
    ORACLE,
    PRINTED,
    SHOWN_MS,
    SPEED_MM_S,
    beyond_rows,
    stored,
)

LENGTHS_UM = (30.0, 0.0)


def test_it_has_every_law_at_both_slip_lengths():
    found = stored()
    assert found.slip_lengths_um == LENGTHS_UM == tuple(found.limit_n)
    assert list(found.cells) == [(law, length_um) for law in LAWS for length_um in LENGTHS_UM]
    assert found.scored["residual_rms_n"].shape == (len(LAWS), 1, len(LENGTHS_UM), 26)
    assert np.isfinite(found.scored["residual_rms_n"].values).all()


@pytest.mark.parametrize("length_um", LENGTHS_UM)
def test_its_medians_are_those_of_its_fingers(length_um):
    found = stored()
    able = found.scored["capable"].values[0]
    for law in LAWS:
        own = found.scored["residual_rms_n"].sel(law=law, slip_length_um=length_um).values[0]
        assert found.value(law, length_um, "residual_rms_n") == pytest.approx(np.median(own[able]), rel=1e-5)
        assert found.cells[law, length_um]["median_finger_rms_n"] in own[able]


def test_steps_that_are_never_followed_and_loops_that_are_not_stable_are_said():
    found = stored()
    rows = {(row["law"], float(row["length"])): row for row in beyond_rows(found)}
    assert {rows[OPEN, 30.0][way] for way in ("fall", "rise")} == {"–"}
    for law in (PRINTED, NOTCH):
        assert rows[law, 30.0]["fall"] == f"{1e3 * found.value(law, 30.0, 'fall_10_90_s'):.2g}"
    assert rows[PRINTED, 30.0]["peak"] == "unstable"
    assert (rows[ORACLE, 30.0]["tick"], rows[ORACLE, 30.0]["oracle"]) == ("–", "1")


def test_steps_are_drawn_in_a_row_for_each_law_from_the_level_before_on():
    figure = figure_step_traces(stored().steps, SPEED_MM_S, SHOWN_MS)
    laws = stored().steps["law"].values.tolist()
    assert [axes.get_ylabel() for axes in figure.axes[::4]] == laws == list(LAWS[2:])
    titles = [axes.get_title("left") for axes in figure.axes[:4]]
    assert titles == [f"slip length {length_um:g} um, step {way}" for length_um in LENGTHS_UM for way in ("down", "up")]
    first = stored().steps.isel(time=0)
    assert np.all(first["f_r"] == 0.75) and np.allclose(first["f_a"], 0.75, atol=0.05)


def test_its_ticks_are_those_that_are_counted():
    kinds = {"open loop": "lookup", "printed gains": "pi", "re-tuned gains": "pi", NOTCH: "notch_pi"}
    found = {law: stored().tick_instructions[law] for law in kinds}
    assert found == {law: worst_tick(kind) for law, kind in kinds.items()}
