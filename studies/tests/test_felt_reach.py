"""What touch feels under the best linear controllers: their rms is known, and one is had at the price of the other."""

from __future__ import annotations

import numpy as np
import pytest
from designed_notch import DESIGNED_NOTCH

import frictionloop as fl
from frictionloop.perception.detection_thresholds import force_threshold_n
from studies.felt_reach import felt_reach
from studies.linear_reach import linear_reach

BENCH = fl.bench().evolve({"motion.stroke_mm": 240.0, "motion.speed_mm_s": 80.0, "setpoint": fl.Constant(offset_n=0.6)})
SHORT = {"duration_s": 2.0, "levels_n": [0.6]}


@pytest.mark.parametrize("length_um", [11.5, 0.0])
def test_rms_and_index_are_had_for_each_other(length_um: str) -> None:
    own = BENCH.evolve({"finger.slip_length_um": length_um})
    found = felt_reach(own, [{}, {"friction.nominal_n": 0.3}], (0.0, 0.3, 3.0), seed=7, **SHORT)
    least = linear_reach(own, [{}], seed=7, peaks=[1.7], **SHORT)["optimum_rms_n"].sel(measured="force and load")
    rms, index = (found[name].isel(finger=0).values for name in ("rms_n", "relative_index"))
    assert rms[0] == pytest.approx(least.item(), rel=1e-3)
    assert np.all(np.diff(rms) > 0)
    assert np.all(np.diff(index) < 0)
    # Each is the best by its own weight.
    for k, weight in enumerate(found["weight"].values):
        assert np.argmin(rms**2 + weight * (index * _before_n(own)) ** 2) == k
    assert np.isnan(found["rms_n"].isel(finger=1)).all()


def _before_n(own: fl.System) -> float:
    """Return the index before control times F_th(100 Hz), of a simulated plain stroke."""
    run = fl.simulate(own.evolve({"controller.kind": "lookup"}), 3.0, 7)
    return float(fl.perceptual_index(fl.plain_like(run)) * force_threshold_n(100.0))


def test_a_run_is_felt_more_than_what_is_felt_least() -> None:
    own = BENCH.evolve(DESIGNED_NOTCH)
    run = fl.simulate(own, 6.0, 7)
    found = felt_reach(own, [{}], (100.0,), 6.0, 7, levels_n=[0.6])["relative_index"].item()
    assert found < fl.relative_index(run)


def test_a_law_that_may_amplify_nothing_changes_nothing() -> None:
    """For Ms -> 1 Bode's integral leaves S = 1 alone: all rms, and a relative index of 1."""
    found = felt_reach(BENCH, [{}], (1.0,), seed=7, sensitivity_peak=1.0001, **SHORT)
    before = linear_reach(BENCH, [{}], seed=7, peaks=[1.7], **SHORT)["open_rms_n"].sel(measured="force and load")
    np.testing.assert_allclose(found["rms_n"], before.item(), rtol=0.02)
    np.testing.assert_allclose(found["relative_index"], 1.0, rtol=0.02)
