"""A tracker is told the resonance of its own device, the other laws are not."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.design.comparison import compare, protocol
from frictionloop.design.comparison.entrants import BELIEVED_HZ, ERROR, on_device, told

BENCH = fl.bench()
MET = "sensor.resonance_hz"
TRACKER = {"controller.kind": "tracker"}


def test_each_finger_s_device_is_told_within_the_error_of_a_measurement():
    people = protocol.population(BENCH, 6, 11)
    found = told(BENCH, people, TRACKER)
    ratios = np.array([each[BELIEVED_HZ] / each[MET] for each in found])
    np.testing.assert_allclose(np.abs(ratios - 1.0), ERROR, rtol=1e-9)
    assert sorted({round(each[MET] / 145.0, 9) for each in found}) == [0.95, 1.0, 1.05]
    assert [dict(each) | {BELIEVED_HZ: 0.0} for each in found] == [dict(each) | {BELIEVED_HZ: 0.0} for each in people]


def test_a_sensor_without_springs_has_nothing_to_tell():
    plain = BENCH.evolve({"sensor.kind": "lowpass", "controller.model.resonance_hz": 0.0})
    people = protocol.population(plain, 3, 11)
    assert told(plain, people, TRACKER) is people


@pytest.mark.parametrize(("law", "is_one"), [("tracker", True), ("observer", False), ("pi", False)])
def test_a_tracker_alone_is_told(law, is_one):
    people = protocol.population(BENCH, 3, 11)
    assert (told(BENCH, people, {"controller.kind": law}) is not people) == is_one
    assert told(BENCH, people, None) is people
    system = BENCH.evolve({"controller.kind": law})
    other = on_device(system, 0.9)
    assert other.sensor.resonance_hz == pytest.approx(0.9 * 145.0)
    assert other.controller.model.resonance_hz == pytest.approx((0.9 if is_one else 1.0) * 145.0)


def test_a_tracker_is_told_the_sensor_s_resonance_whatever_it_believed():
    system = BENCH.evolve({"controller.kind": "tracker", MET: 80.0})
    assert on_device(system, 1.05).controller.model.resonance_hz == pytest.approx(84.0)
    plain = BENCH.evolve({"controller.kind": "tracker", "sensor.kind": "lowpass"})
    assert on_device(plain, 1.05) is plain


def test_what_it_is_told_decides_what_is_run():
    """A cell of a comparison is a sweep of the fingers that are told, and not of those that are not."""
    ran = compare(BENCH, 3, 11, ["tracker"], (20.0,), duration_s=1.5)
    at = protocol.Condition(20.0, "dahl", "hold 0.6")
    bench = BENCH.evolve({**protocol.overrides_of(at, 1.5), "controller.kind": "tracker"})
    seeds = [protocol.noise_seed(11, at.task)]
    people = protocol.population(BENCH, 3, 11)
    known, unknown = (
        fl.sweep(bench, some, 1.5, seeds, ["rms_error"], score_from_s=1.0)["rms_error"].values.ravel()
        for some in (told(BENCH, people, TRACKER), people)
    )
    cell = ran.cells["rms_error"].sel(law="tracker", speed_mm_s=20.0, contact="dahl", task="hold 0.6").values
    np.testing.assert_array_equal(cell, known)
    assert not np.array_equal(known, unknown)
