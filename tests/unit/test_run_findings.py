"""What is found of a run: forces out of reach or beyond the sensor, what is not scored, turns within contacts."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.firmware.board_compatibility import board_findings
from frictionloop.loop import run_findings
from frictionloop.loop.input_findings import contact_turns
from frictionloop.loop.run_findings import reach_split, unscored_s, without_turn_mm

LIFTS = {"motion.speed_mm_s": 80.0, "motion.contact_s": 2.0, "motion.lifted_s": 0.5, "motion.stroke_mm": 160.0}
VALUES_N = 0.02 * np.sin(2 * np.pi * 3 * np.arange(4000) / 1000)
WEAK = {
    "plate.max_amplitude_um": 2.0,
    "controller.model.max_amplitude_um": 2.0,
    "friction.nominal_n": 1.1,
    "setpoint": fl.Sine(offset_n=0.5, amplitude_n=0.3),
}


def test_the_error_is_split_by_reach_and_the_parts_add_up():
    run = fl.simulate(fl.bench().evolve(WEAK | fl.RETUNED), 2.0)
    mask = run["scored"].values
    split = reach_split(run, mask)
    f_r, d = run["f_r"].values[mask], run["d"].values[mask]
    missed = (f_r < run["floor"].values[mask] + d) | (f_r > run["limit"].values[mask] + d)
    assert split.beyond == missed.mean() and 0.05 < split.beyond < 0.9
    assert np.hypot(split.rms_error_beyond_n, split.rms_error_within_n) == pytest.approx(fl.rms_error(run, mask))
    (found,) = run_findings.of_reach(run, mask, split)
    assert (found.code, found.severity) == ("SETPOINT-REACH", "note")
    within = fl.simulate(fl.bench().evolve(fl.RETUNED), 2.0)
    assert reach_split(within, within["scored"].values).beyond == 0.0


def codes(run):
    mask = np.ones(run.sizes["time"], bool)
    return {each.code: each for each in run_findings.of_reach(run, mask, reach_split(run, mask))}


def test_a_set_point_above_the_finger_is_found_with_what_could_be_had():
    high = {"setpoint": fl.Constant(offset_n=1.7), "disturbance": fl.Constant()}
    (found,) = codes(fl.simulate(fl.paper().evolve(high), 0.1)).values()
    assert (found.severity, found.value) == ("warning", 100.0)
    assert (found.more["low"], found.more["high"]) == pytest.approx((0.0744, 0.8), abs=1e-3)
    assert codes(fl.simulate(fl.feasible(), 0.1)) == {}


def test_a_swing_that_no_level_makes_up_for_is_found():
    pulses_n = np.where(np.arange(3000) / 1000.0 % 0.5 < 0.2, 2.0, 0.0)  # a mean of 0.8 N, 0.98 N rms about it
    signals = {"setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Samples(values_n=pulses_n, rate_hz=1000.0)}
    found = codes(fl.simulate(fl.feasible().evolve(signals), 2.9))
    assert found["DISTURBANCE-WIDE"].value == pytest.approx(0.98, abs=0.01)
    assert found["SETPOINT-REACH"].remedy == {}


def test_a_force_beyond_the_sensor_is_found():
    pressed = {"sensor.range_n": 1.0, "motion.load_n": 1.0, "controller.kind": "lookup"}
    run = fl.simulate(fl.bench().evolve(pressed), 2.0)
    everything = np.ones(run.sizes["time"], bool)
    (found,) = run_findings.of_sensor(run, everything)
    assert found.more["share"] == pytest.approx(100.0 * float((run.f_a.values > 1.0).mean())) and found.limit == 1.0
    assert list(run_findings.of_sensor(fl.simulate(fl.feasible(), 0.2), np.ones(1000, bool))) == []


def slid(**changes):
    recorded = {"disturbance": fl.Samples(values_n=VALUES_N, rate_hz=1000.0), "setpoint": fl.Constant(offset_n=0.5)}
    return fl.bench().evolve(recorded | fl.RETUNED | {"motion.stroke_mm": 20.0} | changes)


def test_the_seconds_that_are_not_scored_are_those_of_the_run_and_the_stroke_has_no_turn():
    run = fl.simulate(slid(), 3.0)
    off = np.r_[False, ~run.scored.values, False]
    edges = np.flatnonzero(np.diff(off.astype(int))).reshape(-1, 2)
    assert unscored_s(run) == tuple((run.time.values[a], run.time.values[b - 1]) for a, b in edges)
    (found,) = run_findings.of_unscored(run)
    longer = fl.simulate(slid().evolve(found.remedy), 3.0)
    assert [start for start, _ in unscored_s(longer)] == [0.0]
    shorter = fl.simulate(slid(**{"motion.stroke_mm": found.remedy["motion.stroke_mm"] - 10.0}), 3.0)
    assert len(unscored_s(shorter)) == 2
    assert list(run_findings.of_unscored(fl.simulate(slid(disturbance=fl.Sine(amplitude_n=0.02)), 3.0))) == []


@pytest.mark.parametrize("changes", [{"motion.start": 0.25}, {"motion.contact_s": 1.0}, {"motion.stroke_mm": 500.0}])
def test_no_stroke_is_named_where_none_is_known_or_needed(changes):
    assert without_turn_mm(slid(**changes), 3.0) is None


@pytest.mark.parametrize("speed_mm_s", [20.0, 80.0, 150.0])
def test_the_remedy_makes_each_contact_one_stroke(speed_mm_s):
    system = fl.bench().evolve(LIFTS | {"motion.speed_mm_s": speed_mm_s, "motion.tremor_um": 0.0})
    remedies = [each.remedy for each in contact_turns(system)]
    one = system.evolve(*remedies) if remedies else system
    assert list(contact_turns(one)) == []
    run = fl.simulate(one, 10.0)
    turned = np.abs(run["speed"].values) < 0.999 * np.abs(run["speed"].values).max()
    assert np.ptp(run["speed"].values) > 0 and turned.any() and not np.any(turned & (run["load"].values > 0.0))


def test_a_finger_that_goes_back_and_forth_within_a_contact_means_it():
    back_and_forth = fl.bench().evolve(LIFTS | {"motion.contact_s": 6.0})
    for system in (fl.bench(), fl.paper(), back_and_forth):
        assert list(contact_turns(system)) == []


def test_a_stroke_brings_the_plate_and_the_scale_that_read_it():
    (long,) = contact_turns(fl.bench().evolve(LIFTS | {"motion.speed_mm_s": 150.0}))
    assert long.remedy["touch.load.length_mm"] == long.remedy["motion.stroke_mm"] == pytest.approx(346.875)
    lifts = fl.bench().evolve(LIFTS | {"motion.speed_mm_s": 50.0, "motion.contact_s": 1.0})
    (found,) = contact_turns(lifts)
    made = lifts.evolve(found.remedy)
    assert made.motion.stroke_mm > 65.5 and not list(board_findings(made))
    (short,) = contact_turns(lifts.evolve({"motion.contact_s": 0.5}))
    assert not any(path.startswith("board.") for path in short.remedy)
