"""The schedule of the tracker keeps the limits of Ms that its design checks."""

from __future__ import annotations

import pytest
from tracker_loop import Row
from tracker_rows import Prediction

import frictionloop as fl
from frictionloop.control.tracker_gains import observed
from frictionloop.design.wanted import Wanted
from frictionloop.parameters.tracking import PLACES, SCHEDULE


@pytest.mark.parametrize("place", PLACES)
def test_the_default_rows_keep_the_limits_of_ms(place):
    bench = fl.bench().evolve({"controller.kind": "tracker"})
    search = Prediction(bench, bench.controller.model, observed(bench.controller), place, Wanted().limits)
    peaks = search.residual(Row(*SCHEDULE[PLACES.index(place)]))[1]
    for off, limit in search.limits.items():
        assert max(peaks[off], peaks[-off]) <= limit
