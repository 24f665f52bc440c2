"""Python warns where a signal is probably read wrongly, with the remedy in its own words; the rest runs in silence."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis.operating_point import misread

RATE_HZ = 1000.0
TIME_S = np.arange(3000) / RATE_HZ
VARIES_N = 0.05 * np.sin(2 * np.pi * 2 * TIME_S)
SIGNED_N = (0.4 + VARIES_N) * np.where(TIME_S < 1.5, 1, -1)
LEVEL = fl.feasible().evolve({"setpoint": fl.Constant(offset_n=0.5)})


def array(values):
    return fl.Samples(values_n=values, rate_hz=RATE_HZ)


def recorded(folder, values, column="Ft", **more):
    np.savetxt(folder / "f.csv", np.c_[TIME_S, values], header=f"time_s,{column}", comments="", delimiter=",")
    return fl.Recording(path=str(folder / "f.csv"), column=column, **more)


CASES = {
    "mean": (0.6 + VARIES_N, "MEAN-DOUBT: disturbance: mean 0.6 N", "remove_mean", "True", "values.mean"),
    "unit": (600 + 1000 * VARIES_N, "UNIT-DOUBT: disturbance = 650 N", "unit", "'mN'", "values / 1000"),
    "signs": (SIGNED_N, "SIGN-DOUBT: disturbance: -0.45 to 0.45 N", "rectify", "True", "abs(values)"),
    "below": (-0.4 + VARIES_N, "SIGN-DOUBT: disturbance: -0.45 to -0.35 N", "rectify", "True", "abs(values)"),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_run_and_a_sweep_warn_with_the_remedy_of_python(tmp_path, name):
    values, seen, parameter, meant, of_array = CASES[name]
    column = recorded(tmp_path, values, **({"unit": "N"} if name == "unit" else {}))
    for signal, remedy in ((column, f"evolve({{'disturbance.{parameter}': {meant}}})"), (array(values), of_array)):
        system = LEVEL.evolve({"disturbance": signal})
        for run in (lambda: fl.simulate(system, 0.1), lambda: fl.sweep(system, {"controller.kp": [5.0, 9.0]}, 0.1)):  # noqa: B023
            with pytest.warns(fl.SignalWarning) as caught:
                run()
            (one,) = caught
            assert seen in str(one.message) and remedy in str(one.message)
            assert one.filename == __file__


@pytest.mark.parametrize("name", CASES)
def test_the_remedy_silences(tmp_path, name):
    values, _, parameter, meant, _ = CASES[name]
    wrong = LEVEL.evolve({"disturbance": recorded(tmp_path, values)})
    right = wrong.evolve({f"disturbance.{parameter}": {"True": True, "'mN'": "mN"}[meant]})
    right = right.evolve({"disturbance.remove_mean": True})
    assert misread(right) == []


@pytest.mark.parametrize("system", [LEVEL, fl.bench(), LEVEL.evolve({"setpoint": fl.Constant(offset_n=1.1)})])
def test_what_is_meant_runs_in_silence(tmp_path, system):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for signal in (VARIES_N, VARIES_N - 0.02, np.random.default_rng(0).normal(size=3000) * 0.05):
            fl.simulate(system.evolve({"disturbance": array(signal)}), 0.1)
        if system.setpoint.kind == "constant" and system.setpoint.offset_n == 1.1:  # friction's mean is asked for too
            fl.simulate(system.evolve({"disturbance": array(0.6 + VARIES_N)}), 0.1)


SMALL = {
    "mN": ({"unit": "mN"}, {"disturbance.unit": "N"}),
    "file": ({"column": "Ft [mN]"}, {"disturbance.scale": 1.0}),
    "scale": ({"scale": 1e-3}, "another disturbance.scale"),
}


@pytest.mark.parametrize("name", SMALL)
def test_a_variation_that_is_too_small_for_newtons_warns(tmp_path, name):
    given, remedy = SMALL[name]
    system = LEVEL.evolve({"disturbance": recorded(tmp_path, VARIES_N, **given)})
    with pytest.warns(fl.SignalWarning, match="UNIT-DOUBT: rms of disturbance = 3.54e-05 N"):
        fl.simulate(system, 0.1)
    (found,) = misread(system)
    assert (found.value, found.remedy) == (pytest.approx(3.54e-5, rel=1e-2), remedy)


def test_a_small_array_is_how_a_response_is_measured_and_asks_nothing():
    for values_n in (VARIES_N / 1000, np.zeros(3000), np.full(3000, 0.1)):
        assert misread(LEVEL.evolve({"disturbance": array(values_n)})) == []


def test_a_level_that_was_given_is_meant(tmp_path):
    given = recorded(tmp_path, VARIES_N, offset_n=0.6)
    assert misread(LEVEL.evolve({"disturbance": given})) == []


def test_a_metric_says_why_it_is_nan_where_the_recording_of_a_run_is_gone(tmp_path):
    bench = fl.bench().evolve({**fl.RETUNED, "disturbance": recorded(tmp_path, VARIES_N)})
    run = fl.simulate(bench, 1.0)
    before = fl.metrics(run)
    (tmp_path / "f.csv").rename(tmp_path / "moved.csv")
    with pytest.warns(fl.SignalWarning, match="relative_index is NaN, .*f.csv: there is no such file") as caught:
        after = fl.metrics(run)
    assert caught[0].filename == __file__
    assert before["relative_index"] > 0 and np.isnan(after["relative_index"])
    assert after["disturbance_left"] == before["disturbance_left"]


def test_a_swing_that_no_level_makes_up_for_is_no_question_of_its_mean():
    pulses_n = np.where(TIME_S % 0.5 < 0.2, 2.0, 0.0)  # a mean of 0.8 N, 0.98 N rms about it
    system = LEVEL.evolve({"disturbance": array(pulses_n)})
    assert misread(system) == []
