"""The schedule that the tracker has by default is what its tuning finds."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.design.tracker_tuning import tune_tracker
from frictionloop.parameters.tracking import SCHEDULE, SHARES, TrackerController


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_default_schedule_is_that_of_the_bench():
    """Gains within 1 % of those written down; Ms 2.0 kept but for the 2 % that the search allows.

    12 to 25 s alone, minutes where threads of the linear algebra contend for the cores.
    """
    tuning = tune_tracker(fl.bench())
    np.testing.assert_allclose(tuning.rows, SCHEDULE, rtol=0.01)
    assert len(tuning.peaks) == len(SHARES)
    assert max(peaks[0.0] for peaks in tuning.peaks) <= 2.04
    fields = TrackerController.model_fields
    for name in ("resonance_share", "broadened_q"):
        assert tuning.overrides[f"controller.{name}"] == fields[name].default
