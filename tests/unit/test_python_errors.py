"""What is no run, and what are no points, is refused in one line."""

from __future__ import annotations

import pytest

import frictionloop as fl


@pytest.mark.parametrize("given", [3, None, "run.h5", {}])
@pytest.mark.parametrize(
    "metric", [fl.metrics, fl.r2_identity, fl.rms_error, fl.r2_bound, fl.saturation_index, fl.regression]
)
def test_what_is_no_run_has_no_score(metric, given):
    with pytest.raises(fl.FrictionloopError, match=rf"^run\b.* {type(given).__name__}\b.*fl\.simulate"):
        metric(given)


def test_a_grid_has_its_metrics_already():
    grid = fl.sweep(fl.paper(), {"controller.kp": [1.0, 2.0]}, duration_s=0.01)
    with pytest.raises(fl.FrictionloopError, match=r"^run: Dataset is no run"):
        fl.metrics(grid)


def test_a_sweep_of_no_points_is_refused():
    with pytest.raises(fl.FrictionloopError, match=r"^points = 3: .*\{path: values"):
        fl.sweep(fl.paper(), 3, duration_s=0.01)
