"""Where the residual comes from: on the fingers that are scored."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.design import comparison as rooms
from frictionloop.design.comparison import trial_protocol
from studies.why import reason_rows, reasons


@pytest.fixture(scope="module")
def ran():
    return rooms.run_laws(fl.bench(), ["lookup", "retuned_pi"], 3, 0, [20.0], duration_s=1.6, progress=False)


def test_reasons_are_those_of_the_fingers_that_are_scored(ran):
    found = reasons(ran, ["retuned_pi"])
    able = np.flatnonzero(trial_protocol.able(ran.system, ran.people, 20.0, ran.duration_s))
    numbers = (able if able.size else np.arange(len(ran.people))).tolist()
    assert found["finger"].values.tolist() == numbers
    cell = ran.cells["rms_error"].sel(law="retuned_pi", speed_mm_s=20.0, task="sine 0.6", finger=numbers)
    for length_um in (11.5, 0.0):
        got = found["all"].sel(law="retuned_pi", speed_mm_s=20.0, slip_length_um=length_um).values
        assert np.array_equal(got, cell.sel(slip_length_um=length_um).values)
    rows = reason_rows(found)
    roughness = next(row for row in rows if (row["part"], row["slip_length_um"]) == ("roughness", 11.5))
    cost = found["cost"].sel(law="retuned_pi", speed_mm_s=20.0, slip_length_um=11.5, cause="roughness").values
    assert roughness["cost_median"] == pytest.approx(np.median(cost), rel=1e-12)
