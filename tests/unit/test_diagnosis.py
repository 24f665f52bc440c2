"""How good a run is, as numbers: what `fl.diagnose` returns and finds."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.loop.run_ringing import of_ringing, rings_alone, run_ringing
from frictionloop.parameters.presets import STILL
from frictionloop.parameters.summary import summary

SLOW = {"setpoint": fl.Constant(offset_n=0.6), "disturbance": fl.Sine(amplitude_n=0.01)}


def codes(found):
    return {each.code: each for each in found.findings}


def test_the_metrics_are_those_of_the_run():
    run = fl.simulate(fl.bench().evolve(fl.RETUNED), 3.0, seed=3)
    found, plain = fl.diagnose(run), fl.metrics(run)
    named = {name.removesuffix("_n"): value for name, value in found.metrics.items()}
    assert named == pytest.approx(plain, nan_ok=True)
    assert (found.seed, found.duration_s, found.system) == (3, 3.0, fl.system_of(run))
    assert found.scored == run.scored.values.mean()
    opened = fl.simulate(found.system.evolve({"controller.kind": "lookup"}), 3.0, seed=3)
    assert found.open_loop_rms_error_n == pytest.approx(fl.rms_error(opened))
    assert found.table("error")["rms, mN"]["open loop"] == 1e3 * found.open_loop_rms_error_n
    assert math.isnan(fl.diagnose(opened).open_loop_rms_error_n)
    assert json.loads(found.to_json())["rms_error_n"] == found.rms_error_n


def test_the_start_is_left_out_and_a_part_without_a_scored_period_has_no_metric():
    run = fl.simulate(fl.feasible(), 0.2)
    found = fl.diagnose(run, score_from_s=0.1)
    assert found.rms_error_n == fl.rms_error(run, run.time >= 0.1) and found.scored == pytest.approx(0.5, abs=1e-3)
    assert fl.metrics(fl.scored_from(run, 0.1))["rms_error"] == found.rms_error_n
    nothing = fl.diagnose(run, score_from_s=0.3)
    assert nothing.scored == 0.0 and math.isnan(nothing.rms_error_n)
    assert "mN rms" not in str(nothing)


def test_steps_are_counted_and_timed():
    steps = fl.Steps(times_s=[0.0, 0.1, 0.2], levels_n=[0.4, 0.6, 0.5])
    run = fl.simulate(fl.feasible().evolve({"setpoint": steps}), 0.3)
    found = fl.diagnose(run)
    assert found.steps == tuple(fl.step_times(run)) and found.steps_asked == 2
    assert fl.diagnose(run, score_from_s=0.15).steps_asked == 1


def test_bands_are_those_that_were_asked_for():
    run = fl.simulate(fl.feasible(), 4.0)
    bands = fl.diagnose(run, split_hz=(8, 300)).bands
    left = fl.disturbance_left_by_band(run, [0.0, 8.0, 300.0, np.inf])
    assert [each.disturbance_left for each in bands] == pytest.approx(left.values, nan_ok=True)
    assert [each.low_hz for each in bands] == [0.0, 8.0, 300.0]


@pytest.mark.parametrize(
    ("kp", "how", "alone"), [(0.02, "calm", 0), (0.06, "near", 0), (0.1, "unstable", 0), (0.3, "unstable", 1)]
)
def test_whether_a_loop_rings_on_a_finger_dry_or_moist(kp, how, alone):
    run = fl.simulate(fl.bench().evolve({"controller.kp": kp, "controller.ki": 2.0} | SLOW), 0.5)
    found = run_ringing(run, run["scored"].values)
    assert (found.how, rings_alone(run, run["scored"].values, found)) == (how, alone)
    said = [(each.code, each.severity) for each in of_ringing(found, alone)]
    rings = ("LOOP-UNSTABLE", "error" if alone else "warning")
    assert said == {"calm": [], "near": [("LOOP-NEAR", "warning")], "unstable": [rings]}[how]
    assert 100.0 < found.frequency_hz < 300.0


def test_a_loop_that_its_clamp_keeps_swinging_rings_though_it_is_stable():
    gains = {"controller.kp": 20.0, "setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Sine(amplitude_n=0.02)}
    found = fl.diagnose(fl.simulate(fl.paper().evolve(gains), 1.0), split_hz=(8,))
    assert found.ringing.how == "near" and found.rings_alone and "RING-CLAMP" in codes(found)
    assert found.table("disturbance by frequency")["left, %"].isna().all()  # no share to quote
    assert "of the disturbance left" not in str(found)


def test_a_set_point_out_of_reach_clamps_a_loop_that_does_not_ring():
    asked = {"controller.kp": 0.07, "controller.ki": 2.0, "setpoint": fl.Sine(offset_n=0.9, amplitude_n=0.3)}
    run = fl.simulate(fl.bench().evolve(asked | {"disturbance": fl.Sine(amplitude_n=0.01)}), 10.0)
    mask = run["scored"].values
    found = run_ringing(run, mask)
    assert found.how != "calm" and fl.saturation_index(run, mask) > 0.05
    assert not rings_alone(run, mask, found)


def test_one_function_says_whether_a_loop_rings():
    assert fl.rings(fl.bench()).how == "unstable" and fl.rings(fl.bench()).dry
    calm = fl.rings(fl.bench().evolve(fl.RETUNED))
    assert calm.how == "calm" and calm.sensitivity_peak < 4.0
    moist = fl.rings(fl.bench().evolve({"controller.kp": 0.1, "controller.ki": 2.0}))
    assert moist.how == "unstable" and not moist.dry and moist.where.occluded > 0.3
    slide = fl.Samples(values_n=0.01 * np.sin(np.arange(2000) / 9), rate_hz=1000.0)
    assert fl.rings(fl.bench().evolve({"disturbance": slide})).how == "unstable"


def test_a_law_that_has_no_linear_analysis_is_not_judged():
    late = fl.bench().evolve({"controller.delay_s": 0.25})
    found = fl.diagnose(fl.simulate(late, 2.0))
    assert found.ringing is None and "PLACE-UNSEEN" in codes(found)
    opened = fl.diagnose(fl.simulate(fl.bench().evolve({"controller.kind": "lookup"}), 1.0))
    assert opened.ringing is None and not {"PLACE-UNSEEN", "PLACE-ONE"} & codes(opened).keys()


def test_advice_is_a_design_and_only_on_request(monkeypatch):
    from frictionloop.design import controller_design

    run = fl.simulate(fl.bench(), 0.5)
    designed = []
    monkeypatch.setattr(controller_design, "controller", designed.append)
    assert fl.diagnose(run).advice is None and designed == []
    fl.diagnose(run, advise=True)
    assert designed == [fl.bench()]


def write(folder, values_n, rate_hz=1000.0, **more):
    rows = np.c_[np.arange(values_n.size) / rate_hz, values_n]
    np.savetxt(folder / "s.csv", rows, header="time_s,Ft [N]", comments="", delimiter=",")
    return fl.Recording(path=str(folder / "s.csv"), column="Ft", **more)


def test_what_a_recording_leaves_out_and_comes_on_top_of_is_found(tmp_path):
    at_s = np.arange(2000) / 1000.0
    slide = write(tmp_path, 0.3 + 0.01 * np.sin(20.0 * at_s), remove_mean=True)
    system = fl.bench().evolve({"disturbance": slide} | fl.RETUNED)
    found = fl.diagnose(fl.simulate(system, 1.0))
    part, finger = codes(found)["RECORDED-PART"], codes(found)["RECORDED-FINGER"]
    assert (part.value, part.limit, part.remedy) == (1.0, 2.0, {"disturbance.stop_s": 1.0})
    assert finger.value == pytest.approx(0.3, abs=0.01) and finger.limit == 0.95
    assert found.recorded["disturbance"]["samples"] == 2000
    alone = fl.diagnose(fl.simulate(system.evolve(codes(found)["RECORDED-ON-TOP"].remedy), 2.0))
    assert not {"RECORDED-ON-TOP", "RECORDED-PART"} & codes(alone).keys()
    own = {"friction.nominal_n": 0.6, "disturbance.scale": 2.0}
    other = fl.diagnose(fl.simulate(system.evolve(own), 1.0))
    assert codes(other)["BELIEF-FRICTION"].remedy == {"controller.model.nominal_n": 0.6}
    assert "RECORDED-FINGER" not in codes(other)


def test_a_finger_that_is_held_still_varies_by_the_recording_alone(tmp_path):
    slide = write(tmp_path, 0.5 + 0.02 * (np.arange(2000) >= 1000), remove_mean=True)
    system = fl.bench().evolve({"controller.kind": "lookup", "setpoint": fl.Constant(offset_n=0.6), **STILL})
    run = fl.simulate(system.evolve({"disturbance": slide}), 2.0)
    late = run.scored.values & (run.time.values > 0.5)
    assert np.std((run.f_a - run.d).values[late]) < 0.1 * np.std(run.d.values[late])


def test_of_a_signal_in_another_unit_nothing_else_is_said(tmp_path):
    slide = write(tmp_path, 700.0 + 50.0 * (np.arange(1000) % 2), remove_mean=True, unit="N")
    with pytest.warns(fl.SignalWarning, match="UNIT-DOUBT"):
        run = fl.simulate(fl.feasible().evolve({"disturbance": slide}), 0.9)
    found = fl.diagnose(run)
    assert codes(found)["UNIT-DOUBT"].remedy == {"disturbance.unit": "mN"}
    assert "SETPOINT-REACH" not in codes(found)


def test_a_mean_left_in_is_found_with_what_could_be_had(tmp_path):
    slide = write(tmp_path, 0.6 + 0.05 * (np.arange(500) % 2))
    with pytest.warns(fl.SignalWarning, match="MEAN-DOUBT"):
        run = fl.simulate(fl.bench().evolve({"disturbance": slide}), 0.5)
    found = codes(fl.diagnose(run))
    assert found["SETPOINT-REACH"].remedy == found["MEAN-DOUBT"].remedy == {"disturbance.remove_mean": True}


def test_a_recorded_set_point_beyond_the_sensor_is_found(tmp_path):
    wanted = write(tmp_path, np.where(np.arange(1000) < 500, 0.5, 3.0))
    run = fl.simulate(fl.bench().evolve({"setpoint": wanted} | fl.RETUNED), 1.0)
    beyond = codes(fl.diagnose(run))["RANGE-EXCEEDED"]
    assert (beyond.value, beyond.limit, beyond.more["share"]) == (3.0, 2.5, 50.0)


def test_a_summary_has_what_differs_from_the_defaults_and_what_follows():
    found = summary(fl.bench())
    assert found["controller"].values["kp"] == 10.0 and "rate_hz" not in found["controller"].values
    assert found["plate"].derived["cutoff_hz"] == 100.0
    assert found["sensor"].derived["stiffness_n_um"] == pytest.approx(0.332, abs=1e-3)
    assert "board" not in found and "touch" not in summary(fl.paper())
    assert summary(fl.bench().evolve({"board.ceiling_um": 0.5}))["board"].values == {"ceiling_um": 0.5}
