"""Friction that was measured along one axis has the sign of the motion: its magnitude is taken, or asked about."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.loop import run_findings
from frictionloop.recordings.force_channel import read_recording
from frictionloop.recordings.force_channel import scaled as found
from frictionloop.recordings.friction_defects import signs_of
from frictionloop.recordings.plausibility import doubts_of

RATE_HZ = 1000.0
TIME_S = np.arange(12_000) / RATE_HZ
TO_AND_FRO = np.where(TIME_S // 3 % 2 == 0, 1.0, -1.0)
FRICTION_N = 0.6 + 0.3 * np.sin(2 * np.pi * 0.4 * TIME_S)
NOISE_N = np.random.default_rng(0).normal(size=TIME_S.size)


def recorded(folder, force_n, **more):
    np.savetxt(folder / "f.csv", force_n, header="Ft [N]", comments="", fmt="%.9g")
    return fl.Recording(path=str(folder / "f.csv"), column="Ft", rate_hz=RATE_HZ, **more)


def as_disturbance(signal):
    return fl.feasible().evolve({"setpoint": fl.Constant(offset_n=0.5), "disturbance": signal})


@pytest.mark.parametrize(
    ("more", "force_n"),
    [
        ({"scale": -2.0}, [2.0, 4.0, 6.0]),
        ({"scale": -2.0, "remove_mean": True, "offset_n": 0.5}, [-1.5, 0.5, 2.5]),  # |-2 x| less 4, and 0.5
        ({"unit": "N", "start_s": 0.001, "remove_mean": True}, [-0.5, 0.5]),
    ],
)
def test_the_magnitude_comes_before_the_mean_and_the_offset(tmp_path, more, force_n):
    recording = recorded(tmp_path, [-1.0, 2.0, -3.0], rectify=True, **more)
    np.testing.assert_array_equal(read_recording(recording, RATE_HZ), force_n)


@pytest.mark.parametrize("factor", [1.0, -1e-3, 500.0])
def test_strokes_both_ways_are_seen_in_any_unit(factor):
    lifted = np.where(TIME_S % 3 < 1, 0.0, FRICTION_N * TO_AND_FRO) + 0.003 * NOISE_N
    for force in (FRICTION_N * TO_AND_FRO, lifted):
        assert signs_of(factor * force, 12.0) == "both"


def test_friction_against_the_axis_is_seen():
    assert signs_of(-FRICTION_N, 12.0) == "below"
    assert signs_of(FRICTION_N, 12.0) == signs_of(np.zeros(10), 1.0) == ""


@pytest.mark.parametrize(
    "force",
    [
        np.sin(2 * np.pi * TIME_S),  # 2/pi (asin 0.3 - asin 0.1) = 13 % of it lie between 0.1 and 0.3
        np.sin(2 * np.pi * 40 * TIME_S) - 0.05,
        NOISE_N,
        np.cumsum(NOISE_N) - np.cumsum(NOISE_N).mean(),
        FRICTION_N - FRICTION_N.mean(),
        np.sign(np.sin(2 * np.pi * 10 * TIME_S)),  # turns 20 times per s
        np.where(TIME_S < 11.6, FRICTION_N, -FRICTION_N),  # 3 % of the other sign
    ],
)
def test_what_varies_about_0_by_intent_is_not_asked_about(force):
    assert signs_of(force, 12.0) == ""


def asked(system):
    return list(doubts_of(system))


@pytest.mark.parametrize("removed", [False, True])
def test_signed_friction_is_asked_about_with_its_range_in_the_file(tmp_path, removed):
    signal = recorded(tmp_path, FRICTION_N * TO_AND_FRO, remove_mean=removed)
    (one,) = asked(as_disturbance(signal))
    assert (one.code, one.value, one.remedy) == ("SIGN-DOUBT", "both", {"disturbance.rectify": True})
    assert (one.more["low"], one.more["high"]) == pytest.approx((-0.9, 0.9), abs=1e-6)
    for meant in (True, False):
        assert asked(as_disturbance(signal.model_copy(update={"rectify": meant}))) == []


def test_an_offset_that_lifts_all_values_answers_the_question_about_their_sign(tmp_path):
    signal = recorded(tmp_path, -FRICTION_N)
    assert [each.value for each in asked(as_disturbance(signal))] == ["below"]
    assert asked(as_disturbance(signal.model_copy(update={"offset_n": 1.0}))) == []
    removed = signal.model_copy(update={"offset_n": 1.0, "remove_mean": True})  # a level, not the zero of the sensor
    assert [each.value for each in asked(as_disturbance(removed))] == ["below"]


def test_a_doubt_about_signs_does_not_hide_that_the_set_point_is_out_of_reach(tmp_path):
    with pytest.warns(fl.SignalWarning, match="SIGN-DOUBT"):
        run = fl.simulate(as_disturbance(recorded(tmp_path, -FRICTION_N)), 1.0)
    assert {"SIGN-DOUBT", "SETPOINT-REACH"} <= {each.code for each in fl.diagnose(run).findings}


def test_a_stroke_against_the_axis_is_asked_about_although_its_mean_is_removed(tmp_path):
    signal = recorded(tmp_path, -FRICTION_N, remove_mean=True)
    assert [each.value for each in asked(as_disturbance(signal))] == ["below"]
    right = signal.model_copy(update={"rectify": True})
    assert found(right).force.std() == pytest.approx(FRICTION_N.std())
    assert asked(as_disturbance(right)) == []


def test_a_set_point_about_0_is_to_be_lifted(tmp_path):
    wanted = fl.feasible().evolve({"setpoint": recorded(tmp_path, FRICTION_N * TO_AND_FRO)})
    assert [each.remedy for each in asked(wanted)] == [{"setpoint.rectify": True}]
    about_0 = fl.feasible().evolve({"setpoint": recorded(tmp_path, np.sin(2 * np.pi * TIME_S))})
    assert asked(about_0) == []
    run, everything = fl.simulate(about_0, 1.0), np.ones(5000, bool)
    (one,) = run_findings.of_reach(run, everything, run_findings.reach_split(run, everything))
    assert one.remedy == "another setpoint.offset_n"


def test_arrays_are_asked_about_in_the_words_of_arrays():
    signed = fl.Samples(values_n=FRICTION_N * TO_AND_FRO, rate_hz=RATE_HZ)
    assert [each.remedy for each in asked(as_disturbance(signed))] == ["abs(values)"]
    assert asked(as_disturbance(fl.Samples(values_n=FRICTION_N, rate_hz=RATE_HZ))) == []
