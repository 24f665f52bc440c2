"""The participant's own reach: measured before and after, levels that follow from it, all in the log."""

import json

import pytest

import frictionloop as fl
from frictionloop.experiments import Protocol, read_protocol, read_trials, resume, run
from frictionloop.experiments.levels_within_reach import drawn_together, fitted, needed, share_out
from frictionloop.experiments.protocol import bundled
from frictionloop.physics.reach import Reach
from frictionloop.quantities import FrictionloopError

FINGER = Reach(0.1, 0.4801)
PLAN = read_protocol("jnd-friction-constant")  # 0.3 to 0.5 N


def test_levels_out_of_reach_are_drawn_towards_the_standard_until_all_can_be_given():
    plan, factor = fitted(PLAN, FINGER)
    assert factor == pytest.approx(0.8)
    assert plan.method.levels == pytest.approx([0.8 * each for each in PLAN.method.levels])
    assert needed(plan).high_n <= 0.4801
    assert fitted(PLAN, Reach(0.1, 0.6)) == (PLAN, 1.0)


def test_a_session_is_refused_with_the_share_out_of_reach():
    assert share_out(PLAN, FINGER) == pytest.approx(0.1, abs=0.01)
    with pytest.raises(FrictionloopError, match=r"0\.1 to 0\.48 N; must be 0\.3 to 0\.5 N .10 %"):
        fitted(PLAN.evolve({"out_of_reach": "refuse"}), FINGER)
    assert fitted(PLAN.evolve({"out_of_reach": "mark"}), FINGER)[1] == 1.0
    with pytest.raises(FrictionloopError, match=r"N \(75 % is out\)"):
        fitted(PLAN, Reach(0.1, 0.35))  # the standard itself


@pytest.mark.parametrize("name", bundled())
def test_every_bundled_protocol_can_be_drawn_together(name):
    plan = read_protocol(name)
    low, high = plan.method.extremes()
    found = drawn_together(plan, 0.5, 0.0).method.extremes()
    assert found[1] - found[0] == pytest.approx(0.5 * (high - low))


def test_without_a_standard_the_end_that_can_be_given_stays():
    plan = read_protocol("magnitude-estimation").evolve({"blocks.catch_level": 0.25})  # 0.25 to 0.5 N
    drawn, factor = fitted(plan, Reach(0.1, 0.4501))
    assert factor == pytest.approx(0.8)
    assert drawn.method.levels == pytest.approx([0.25, 0.29, 0.338, 0.394, 0.45])
    assert drawn.blocks.catch_level == 0.25
    upper = fitted(plan, Reach(0.2999, 0.8))[0]
    assert (upper.method.levels[0], upper.method.levels[-1]) == pytest.approx((0.3, 0.5))
    both = fitted(plan, Reach(0.2749, 0.4751))[0]
    assert (both.method.levels[0], both.method.levels[-1]) == pytest.approx((0.275, 0.475))


def test_the_reach_is_measured_before_and_after_and_what_followed_is_in_the_log(tmp_path):
    short = Protocol(stimulus={"standard": 0.35}, method={"kind": "staircase", "start": [0.15], "most": 0.2},
                     timeline={"stroke": {"length_mm": 10.0}}, stop={"trials": 4})  # fmt: skip
    path = run(short, tmp_path / "P01", "P01", trials=2).folder

    def logged(event):
        lines = [json.loads(line) for line in (path / "log.jsonl").read_text().splitlines()]
        return [each for each in lines if each["event"] == event]

    (before,) = logged("reach")
    adjusted = {each["what"]: each["value"] for each in logged("adjusted") if "value" in each}
    assert adjusted["controller.model.nominal_n"] == before["high_n"]
    resume(path)
    assert [each["when"] for each in logged("reach")] == ["before", "after"]
    after = logged("reach")[1]
    assert after["high_n"] == pytest.approx(before["high_n"], rel=0.2)
    system = fl.load(path / read_trials(path)["raw"][3]).attrs["system"]
    assert json.loads(system)["controller"]["model"]["nominal_n"] == before["high_n"]
