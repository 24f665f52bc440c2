"""Where the residual comes from, as a person is shown it, and drawn."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import frictionloop as fl
from frictionloop.design import comparison as rooms
from frictionloop.design.comparison import protocol
from frictionloop.report.style import svg
from studies.why import reason_rows, reasons
from studies.why_figure import figure_why
from studies.why_text import LEGEND, why_summary


@pytest.fixture(scope="module")
def ran():
    return rooms.compare(fl.bench(), 3, 0, ["lookup", "retuned_pi"], [20.0], duration_s=1.6, progress=False)


def test_the_table_and_the_figure_say_where_the_residual_comes_from(ran):
    found = reasons(ran, ["retuned_pi"])
    lines = why_summary(reason_rows(found))
    assert any("20 mm/s, slider: where the residual comes from" in str(line) for line in lines)
    assert all(line in lines for line in LEGEND)
    assert svg(figure_why(found, 20.0), "causes").startswith("<?xml")


def test_a_law_that_did_not_compete_is_refused(ran):
    with pytest.raises(fl.FrictionloopError, match="why: 'observer' is not compared; accepted: lookup, retuned_pi"):
        reasons(ran, ["observer"])


def words(figure):
    return "\n".join(text.get_text() for axes in figure.axes for text in axes.texts)


def test_the_figure_of_causes_tells_laws_apart_without_colour_and_says_what_cannot_be_told():
    causes, laws = ["roughness", "resonance"], ["plain", "best"]
    axes = {"law": laws, "speed_mm_s": [20.0], "contact": ["dahl"], "finger": [0, 1, 2], "cause": causes}
    lengths = {name: len(values) for name, values in axes.items()} | {"band": 2}
    per_finger = ("law", "speed_mm_s", "contact", "finger")

    def full(dims, value):
        return dims, np.full([lengths[dim] for dim in dims], value)

    found = xr.Dataset(
        {
            "all": full(per_finger, 0.02),
            "silent": full(per_finger, 0.001),
            "cost": full((*per_finger, "cause"), 0.0034),
            "band_rms": full(("law", "speed_mm_s", "contact", "band"), 0.005),
        },
        axes | {"low_hz": ("band", [0.0, 5.0]), "high_hz": ("band", [5.0, 15.0])},
    )
    found["cost"].loc[{"law": "best", "cause": "resonance"}] = np.nan
    found["cost"].loc[{"law": "plain", "cause": "resonance"}] = -0.00001
    figure = figure_why(found, 20.0)
    shown = words(figure).splitlines()
    assert {"20.0", "3.4", "5.0", "cannot be told", "0.0"} <= set(shown) and "−0.0" not in shown
    plain, best = (bars.patches[0] for bars in figure.axes[0].containers)
    assert plain.get_hatch() != best.get_hatch() and plain.get_facecolor() != best.get_facecolor()
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == ["all", "no disturbance", *causes]


def test_reasons_are_those_of_the_fingers_that_are_scored(ran):
    found = reasons(ran, ["retuned_pi"])
    able = np.flatnonzero(protocol.able(ran.system, ran.people, 20.0, ran.duration_s))
    numbers = (able if able.size else np.arange(len(ran.people))).tolist()
    assert found["finger"].values.tolist() == numbers
    cell = ran.cells["rms_error"].sel(law="retuned_pi", speed_mm_s=20.0, task="sine 0.6", finger=numbers)
    for contact in protocol.CONTACTS:
        got = found["all"].sel(law="retuned_pi", speed_mm_s=20.0, contact=contact).values
        assert np.array_equal(got, cell.sel(contact=contact).values)
    rows = reason_rows(found)
    roughness = next(row for row in rows if (row["part"], row["contact"]) == ("roughness", "dahl"))
    cost = found["cost"].sel(law="retuned_pi", speed_mm_s=20.0, contact="dahl", cause="roughness").values
    assert roughness["cost_median"] == pytest.approx(np.median(cost), rel=1e-12)
    for wrong in ([], ["retuned_pi", "retuned_pi"], ["oracle"]):
        with pytest.raises(fl.FrictionloopError, match="why"):
            reasons(ran, wrong)
