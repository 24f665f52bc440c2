"""The best point of a sweep, whether its loop rings, and what has no value."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl


def codes(found):
    return {each.code for each in found.findings}


@pytest.mark.parametrize(
    ("metric", "at"),
    [
        ("rms_error", 0),
        ("saturation_index", 0),
        ("perceptual_index", 0),
        ("r2_identity", 3),
        ("slope", 1),
        ("r2_bound", 3),
    ],
)
def test_best_is_the_smallest_the_largest_or_the_nearest_to_one(metric, at):
    result = fl.sweep(fl.feasible(), {"controller.kp": [1, 2, 3, 4]}, 0.01, metrics=[metric])
    result[metric][:] = np.array([[0.5], [1.2], [0.7], [1.4]])
    best = fl.best(result).best[metric]
    assert best.point == {"controller.kp": at + 1}
    assert best.at_end == (("controller.kp",) if at != 1 else ())
    assert best.others == 0


def test_equal_points_are_counted():
    result = fl.sweep(fl.feasible(), {"controller.kp": [1, 2, 3, 4]}, 0.01)
    result["saturation_index"][:] = np.array([[0.5], [0.0], [0.0], [np.nan]])
    best = fl.best(result).best["saturation_index"]
    assert (best.point, best.others, best.at_end) == ({"controller.kp": 2}, 1, ())


def test_points_that_ring_are_told_by_their_margins():
    """The ultimate gain tells which proportional gains are stable, whatever the metrics of so short a run."""
    bench = fl.bench().evolve({"controller.kind": "pi", "controller.ki": 1.0})
    kps = [share * fl.kp_limit(bench) for share in (0.1, 3.0)]
    found = fl.best(fl.sweep(bench, {"controller.kp": kps}, 0.1))
    calm, rings = found.peaks
    assert 1.0 < calm < 2.0 and math.isinf(rings)
    assert found.to_dict()["stable"] == [True, False]
    assert found.table("points")["Ms"].tolist() == [calm, rings]


def test_a_best_point_that_rings_is_a_warning():
    found = fl.best(fl.sweep(fl.feasible(), {"controller.kp": [200.0, 201.0]}, 0.1, metrics=["rms_error"]))
    (told,) = (each for each in found.findings if each.code == "BEST-RINGS")
    assert told.remedy == found.best["rms_error"].point and math.isinf(told.value)


def test_many_points_are_not_listed_and_the_best_at_an_end_is_told():
    kps = np.linspace(1.0, 2.0, 15)
    found = fl.best(fl.sweep(fl.feasible(), {"controller.kp": kps}, 0.5, metrics=["rms_error"]))
    assert found.peaks is None and list(found.tables()) == ["best"]
    (told,) = (each for each in found.findings if each.code == "BEST-AT-END")
    assert told.value == {"controller.kp": 2.0}


def test_a_metric_without_any_value_is_told_and_the_sweep_is_complete():
    constant = {"setpoint.kind": "constant", "setpoint.offset_n": 0.5}
    found = fl.best(
        fl.sweep(fl.feasible().evolve(constant), {"controller.kp": [1.0, 2.0]}, 0.1, metrics=["r2_identity"])
    )
    assert found.complete and found.best == {}
    assert "METRIC-NONE" in codes(found) and "STOPPED" not in codes(found)


def test_points_of_a_list_and_words():
    listed = fl.best(fl.sweep(fl.feasible(), [{"controller.kp": 2.0}, {"controller.kp": 500.0}], 0.1))
    assert math.isfinite(listed.peaks[0]) and math.isinf(listed.peaks[1])
    words = fl.best(fl.sweep(fl.feasible(), {"setpoint.kind": ["log_sweep", "constant"]}, 0.1))
    assert words.best["r2_identity"].point == {"setpoint.kind": "log_sweep"}


def test_what_is_no_sweep_is_refused():
    with pytest.raises(fl.FrictionloopError):
        fl.best(fl.simulate(fl.paper(), 0.1))
