"""Weights as a table: the line, what it leaves, leave-one-out, and what cannot be told."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import frictionloop as fl
from frictionloop.identification import rigs, straightness, weights
from frictionloop.parameters.calibration_bench import CalibrationBench

G = 9.80665
UP = np.arange(8) * 0.05


def table(mass, reading, unit="V"):
    columns = {"mass": ("row", np.asarray(mass, dtype=float), {"units": "kg"})}
    return xr.Dataset(columns | {"f_m": ("row", np.asarray(reading, dtype=float), {"units": unit})})


def test_a_table_of_eight_weights_in_any_order():
    noise = 1e-3 * np.random.default_rng(5).normal(size=8)
    for order in (np.arange(8), np.random.default_rng(1).permutation(8)):
        found = weights(table(UP[order], (0.2 + 0.7 * UP * G + noise)[order]))
        slope, offset = np.polyfit(UP * G, 0.2 + 0.7 * UP * G + noise, 1)  # an independent implementation
        assert found.sensitivity.value == pytest.approx(slope) and found.offset.value == pytest.approx(offset)
        assert found.sensitivity.interval().low < 0.7 < found.sensitivity.interval().high


def test_few_points_have_the_error_of_leaving_one_out():
    reading = 0.7 * UP * G
    reading[-1] += 0.05  # one reading that is off pulls the line, more than the scatter says
    found = weights(table(UP, reading)).left_out
    slopes = [np.polyfit(np.delete(UP, k) * G, np.delete(reading, k), 1)[0] for k in range(8)]
    jackknife = np.sqrt(7 / 8 * np.sum((slopes - np.mean(slopes)) ** 2))
    assert found.standard_error == pytest.approx(jackknife)


def test_coverage_of_a_table_of_eight():
    draw, inside = np.random.default_rng(7), 0
    for _ in range(300):
        found = weights(table(UP, 0.2 + 0.7 * UP * G + 1e-3 * draw.normal(size=8))).sensitivity
        ends = found.interval(0.9)
        inside += ends.low < 0.7 < ends.high
    assert 0.87 <= inside / 300 <= 0.97


def test_steps_up_only_cannot_tell_friction():
    draw = np.random.default_rng(2)
    found = straightness(weights(table(UP, 0.7 * UP * G + 1e-3 * draw.normal(size=8))))
    assert found.friction is None and [each.code for each in found.findings] == ["NOT-TOLD"] and not found.drifts


def test_curvature_drift_and_friction_are_told_apart():
    draw = np.random.default_rng(3)
    around = np.concatenate([UP, UP[-2::-1]])
    x = around / UP[-1]
    scatter = 1e-4 * draw.normal(size=x.size)
    bent = straightness(weights(table(around, 0.7 * around * G * (1 + 0.02 * x) + scatter)))
    assert bent.curved and not bent.drifts
    assert bent.curvature.value == pytest.approx(0.02 / 1.02 / 4, rel=0.05)
    # Unordered weights, so that neither a bend nor friction looks like a drift.
    some = draw.permutation(np.repeat(UP, 2))
    slow = straightness(
        weights(table(some, 0.7 * some * G + np.linspace(0, 0.01, some.size) + 1e-4 * draw.normal(size=16)))
    )
    assert slow.drifts and not slow.curved
    assert slow.drift.value == pytest.approx(0.01 / 0.7, rel=0.1)


def test_the_friction_of_a_rig_with_a_peg_is_told():
    bench = CalibrationBench().evolve({"pulley.bearing_friction": 1e9, "pulley.string_friction": 0.02})
    found = straightness(weights(rigs.weights_rig([0.8 * mass for mass in rigs.UP_AND_DOWN_KG], bench)))
    truth = rigs.friction_exponent(bench.pulley)
    assert found.friction is not None and found.friction.exponent.value == pytest.approx(truth, rel=0.05)
    assert any(each.more.get("what") == "friction of the pulley" for each in found.findings)


@pytest.mark.parametrize(
    ("factor", "word"), [(9.80665, "unit = kg"), (1000.0, "unit = mN"), (1 / 9.80665, "unit = kg")]
)
def test_a_wrong_unit_is_suspected_aloud(factor, word):
    found = weights(table(UP, factor * UP * G, "N"))
    assert word in [each.remedy for each in straightness(found).findings]


def test_masses_in_grams_are_suspected():
    doubts = straightness(weights(table(1e3 * UP, 0.7 * UP * G))).findings
    assert "unit = g" in [each.remedy for each in doubts]


def test_what_a_table_refuses():
    with pytest.raises(fl.FrictionloopError, match="3 or more"):
        weights(table([0, 0.1], [0, 1]))
    with pytest.raises(fl.FrictionloopError, match="slope of f_m = 0"):
        weights(table(UP, np.ones(8)))
