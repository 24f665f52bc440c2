"""Step times of a comparison over references and bounds."""

from __future__ import annotations

import numpy as np

import frictionloop as fl
from frictionloop.design import comparison as rooms
from frictionloop.design.comparison import plain, protocol
from studies.step_limits import step_limits
from studies.step_times import HEADS, over_limits, rows


def test_step_times_are_over_those_of_reference_and_bound():
    times = {"duration_s": 2.0, "start_s": 0.5, "progress": False}
    ran = rooms.compare(fl.bench(), 3, 9, ["retuned_pi"], [80.0], **times)
    scored = rooms.scores(ran)
    over = over_limits(ran, scored)
    assert [len(row) for row in rows(ran, scored, over)] == [len(HEADS) + 2 * len(over)] * len(scored["slip_length_um"])
    for length_um in scored["slip_length_um"].values.tolist():
        at = protocol.Condition(80.0, length_um, protocol.STEPPED)
        occluded = plain.occluded_at(fl.bench(), 1.25)
        found = step_limits(fl.bench().evolve(protocol.overrides_of(at)), ran.people, occluded)
        here = {"law": "retuned_pi", "speed_mm_s": 80.0, "slip_length_um": length_um}
        for against, shortest in (("limit", found.reference), ("bound", found.bound)):
            for name, each in shortest._asdict().items():
                ratio = over[f"{name.removesuffix('_s')}_over_{against}"].sel(here).values
                np.testing.assert_allclose(ratio, scored[name].sel(here).values / each, rtol=1e-12)
