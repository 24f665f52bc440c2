"""Forces asked for that are out of reach: refused where none is left, and named where another stands for them."""

from __future__ import annotations

import re

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis.band import operating_band
from frictionloop.analysis.occlusions import occlusions
from frictionloop.analysis.reach import Missed, missed
from frictionloop.cli import advice_text, ringing
from frictionloop.cli.controller_holds import beyond_reach
from frictionloop.cli.controller_text import turn
from frictionloop.cli.saved_controller import instead_of
from frictionloop.design import synthesis
from frictionloop.design.requirements import feedforward

BENCH = {
    "plate.max_amplitude_um": 2.0,
    "controller.model.max_amplitude_um": 2.0,
    "friction.nominal_n": 1.1,
    "sensor.resonance_hz": 170.0,
    "setpoint": fl.Sine(offset_n=0.5, amplitude_n=0.3),
}


def bench(amplitude_n: float) -> fl.System:
    return fl.bench().evolve(BENCH).evolve({"setpoint.amplitude_n": amplitude_n})


@pytest.mark.slow
def test_a_force_that_no_amplitude_leaves_counts_as_the_nearest_that_it_does():
    found = synthesis.design_controller(bench(0.3), "pi").corners
    dry = [each.loop.elements.force_n for each in found if each.loop.elements.occluded == 0.0]
    (beyond,) = missed(bench(0.3))
    assert (beyond.force_n, beyond.instead_n) == (pytest.approx(0.2), pytest.approx(min(dry)))


def test_where_none_can_be_had_the_design_is_refused_before_any_search(monkeypatch):
    monkeypatch.setitem(synthesis.SYNTHESES, "notch_pi", lambda *_: pytest.fail("it searched"))
    weak = bench(0.02).evolve({"setpoint.offset_n": 0.2})
    with pytest.raises(fl.FrictionloopError, match="saturation is the limit") as refused:
        synthesis.design_controller(weak)
    more_um, less_n = (
        float(each) for each in re.search(r"than (\S+) um .* below (\S+) N", str(refused.value)).groups()
    )
    for change in ({"plate.max_amplitude_um": 1.001 * more_um, "controller.model.max_amplitude_um": 1.001 * more_um},
                   {"friction.nominal_n": 0.995 * less_n}):  # fmt: skip
        assert missed(weak.evolve(change | {"setpoint.offset_n": 0.22, "setpoint.amplitude_n": 0.0})) == []


def test_the_force_evaluated_in_place_of_another_is_that_of_the_loops():
    system = bench(0.2)
    states = occlusions(system)
    (beyond,) = missed(system, states)
    evaluated = [loop.elements for loop in operating_band(system, occluded=states)]
    assert min(each.force_n for each in evaluated if each.occluded > 0) == pytest.approx(beyond.instead_n, rel=1e-12)
    assert instead_of([system], states) == [
        "0.3 N is out of reach of a moist finger (occluded 39%): 0.401 N is evaluated in its place.",
        "`frictionloop sweep FILE --fingers 100` says how many fingers can be given these forces.",
    ]


def test_a_verdict_names_the_fingers_a_force_is_out_of_reach_of_and_what_to_change():
    system = bench(0.2)
    states = occlusions(system)
    (name, said), (_, ask), (_, many) = beyond_reach([system], states)
    assert name == "OUT OF REACH"
    assert said.startswith("0.3 N of a moist finger (occluded 39%): 0.401 N is looked at, near the least")
    assert "Ask for more" in ask and "max_amplitude_um" in ask and "sweep FILE --fingers" in many
    assert beyond_reach([system.evolve({"setpoint.offset_n": 0.65, "setpoint.amplitude_n": 0.1})], states) == []
    too_much = beyond_reach([system.evolve({"setpoint.offset_n": 0.95, "setpoint.amplitude_n": 0.3})], [0.0])
    assert "Ask for less" in too_much[1][1] and "max_amplitude_um" not in too_much[1][1]


def test_over_speeds_the_least_force_is_that_of_the_speed_with_most_friction():
    tilt = {"friction.speed_slope": -0.15}
    slow, fast = (bench(0.2).evolve(tilt | {"motion.speed_mm_s": speed}) for speed in (10.0, 60.0))
    state = occlusions(slow)[-1]
    least_n = {each.motion.speed_mm_s: missed(each, [state])[0].instead_n for each in (slow, fast)}
    worst = max(least_n, key=least_n.__getitem__)
    assert min(least_n.values()) < max(least_n.values())
    said = f"0.3 N of a moist finger (occluded 39%): {least_n[worst]:.3g} N at {worst:g} mm/s is looked at"
    assert beyond_reach([slow, fast], [state])[0][1].startswith(said)
    same = [each.evolve({"friction.speed_slope": 0.0}) for each in (slow, fast)]
    assert "mm/s" not in beyond_reach(same, [state])[0][1]


def test_a_force_and_the_nearest_have_digits_that_tell_them_apart():
    assert Missed(0.6, 0.5996, 0.0).in_words == ("0.6", "0.5996")
    assert Missed(0.3, 0.401234, 0.0).in_words == ("0.3", "0.401")


@pytest.mark.parametrize(("margin", "said"), [(58.4, "58 lag"), (-35.8, "36 lead"), (float("inf"), "∞")])
def test_a_phase_margin_says_its_direction(margin, said):
    assert turn(margin) == said


def test_advice_says_which_level_it_leaves_out():
    found = ringing.of_system(bench(0.3).evolve({"controller.kp": 10.0, "controller.ki": 2.0}))
    assert found is not None
    said = " ".join(advice_text.lines(found, {"saturation_index": 0.0, "r2_identity": 1.0}))
    assert "(0.241 to 0.8 N; 0.2 N is out of reach)" in said


def test_advice_on_levels_within_reach_says_nothing_of_reach():
    system = fl.bench().evolve({"controller.kp": 10.0, "controller.ki": 2.0})
    found = ringing.of_system(system)
    assert found is not None
    assert found.band.out_of_reach_n == ()


def test_the_error_is_split_by_reach_and_the_parts_add_up():
    system = bench(0.3).evolve(fl.RETUNED)
    run = fl.simulate(system, 2.0)
    mask = run["scored"].values.astype(bool) if "scored" in run else np.ones(run.sizes["time"], dtype=bool)
    said = " ".join(advice_text.out_of_reach(run, mask))
    error, f_r, d = (run["f_a"] - run["f_r"]).values[mask], run["f_r"].values[mask], run["d"].values[mask]
    missed_at = (f_r < run["floor"].values[mask] + d) | (f_r > run["limit"].values[mask] + d)
    beyond, within = (np.sqrt(np.mean(np.where(there, error, 0.0) ** 2)) for there in (missed_at, ~missed_at))
    assert 0.05 < missed_at.mean() < 0.9
    assert f"out of reach {missed_at.mean():.0%} of the time" in said
    assert f"{1e3 * beyond:.3g} mN come from there, {1e3 * within:.3g} mN from within reach" in said
    assert np.hypot(beyond, within) == pytest.approx(fl.rms_error(run, mask), rel=1e-9)


def test_a_set_point_within_reach_has_no_split():
    run = fl.simulate(fl.bench().evolve(fl.RETUNED), 2.0)
    mask = np.ones(run.sizes["time"], dtype=bool)
    assert advice_text.out_of_reach(run, mask) == []


def test_no_feed_forward_where_the_set_point_reaches_the_believed_friction():
    bench = fl.bench()
    assert feedforward(bench) == (True, ())
    forward, (why,) = feedforward(bench.evolve({"setpoint.offset_n": 0.9}))
    assert not forward and "the set-point reaches 1 N, and controller.model.nominal_n" in why
    assert feedforward(bench.evolve({"setpoint.offset_n": 0.9, "controller.model.nominal_n": 1.3}))[0]
