"""One controller on many fingers, by their loop gains and one by one: as one check would find each."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis.linear import linearise
from frictionloop.analysis.operating_point import law_at, moistest
from frictionloop.design import controller_design
from frictionloop.design.controller_design import controller
from frictionloop.design.grid_corners import MET, corners
from frictionloop.design.operating_grid import ITSELF, OperatingGrid
from frictionloop.design.population_margins import (
    MOST_PEAK,
    FingersInterrupted,
    check_fingers,
    loop_gain,
    loop_gains,
    of_fingers,
)
from frictionloop.design.requirements import Designed, Requirements
from frictionloop.experiments.measured_finger import MeasuredFinger
from frictionloop.physics.reach import Reach

PI = fl.bench().evolve({"controller.kind": "pi", "controller.kp": 0.03, "controller.ki": 20.0})
PEOPLE = fl.fingers(8, 0)
FEW = Requirements(slip_lengths_um=(), resonance_error=0.05)


@pytest.mark.slow
def test_each_finger_is_as_a_check_of_it_alone_finds_it():
    found = check_fingers(PI, PEOPLE[:4], FEW)
    for k, person in enumerate(PEOPLE[:4]):
        alone = corners(PI.evolve(person), FEW.grid(3, 2))
        worst = max(alone, key=lambda each: each.excess)
        mine = found.isel(finger=k)
        if np.isfinite(worst.sensitivity_peak):
            assert mine.sensitivity_peak / mine.limit == pytest.approx(worst.excess, rel=0.01)
        assert bool(mine.stable) == np.isfinite(worst.sensitivity_peak)
        assert bool(mine.holds) == (worst.excess <= 1.0 + MET)
        least = min(each.loop.gain_factor(each.limit) for each in alone)
        assert float(mine.gain_factor) == pytest.approx(least, rel=1e-9)
        assert float(mine.load_n) == person["motion.load_n"]


@pytest.mark.slow
def test_the_gains_proposed_for_all_hold_on_all_and_more_do_not():
    least = float(check_fingers(PI, PEOPLE).gain_factor.min())
    assert least < 1.0

    def held(factor):
        gains = {f"controller.{name}": factor * getattr(PI.controller, name) for name in ("kp", "ki")}
        return int(check_fingers(PI.evolve(gains), PEOPLE).holds.sum())

    assert held(0.999 * least) == len(PEOPLE)
    assert held(1.02 * least) < len(PEOPLE)


def test_a_finger_that_cannot_be_looked_at_is_told_and_holds_nowhere():
    people = [PEOPLE[0], PEOPLE[1] | {"motion.load_n": 0.001}]
    found = check_fingers(PI, people, FEW)
    assert found.unseen.values[0] == "" and "motion.load_n = 0.001 N" in str(found.unseen.values[1])
    assert not found.holds.values[1] and np.isnan(found.sensitivity_peak.values[1])
    with pytest.raises(fl.FrictionloopError, match=r"people: .*motion.load_n = 0.001"):
        check_fingers(PI, people[1:], FEW)
    with pytest.raises(fl.FrictionloopError, match=r"people: needs one"):
        check_fingers(PI, [], FEW)


def test_forces_out_of_a_fingers_reach_are_told():
    strong, weak = (PEOPLE[0] | {"friction.nominal_n": nominal_n} for nominal_n in (0.95, 0.3))
    found = check_fingers(PI, [strong, weak], FEW)
    assert "no force asked for in reach" in str(found.unseen.values[1]) and not found.holds.values[1]
    there = [loop.elements for loop in ITSELF.loops(PI.evolve(strong))]
    few = PI.evolve({"setpoint.amplitude_n": 0.0, "setpoint.offset_n": max(at.force_n for at in there)})
    assert check_fingers(few, [strong], FEW).in_reach.values[0]
    wide = PI.evolve({"setpoint.amplitude_n": 0.4})
    assert not check_fingers(wide, [strong], FEW).in_reach.values[0]


def test_a_force_that_is_the_nearest_but_not_asked_for_counts_for_nothing():
    # A moist finger that cannot be given as little as is asked for: its command stays at the limit, and cannot ring.
    sticky = PEOPLE[0] | {"friction.nominal_n": 0.9, "friction.occlusion_ratio": 5.0, "friction.moist_loss": 0.7}
    low = PI.evolve({"setpoint.amplitude_n": 0.02, "setpoint.offset_n": 0.4, "motion.contact_s": 30.0})
    found = check_fingers(low, [sticky], FEW)
    assert found.unseen.values[0] == "" and found.occluded.values[0] == 0.0 and not found.in_reach.values[0]


def test_loads_asked_for_replace_the_load_of_each_finger():
    found = check_fingers(PI, PEOPLE[:3], Requirements(slip_lengths_um=(11.5,), loads_n=(0.4, 0.9)))
    assert set(found.load_n.values) <= {0.4, 0.9}
    own = check_fingers(PI, PEOPLE[:3], FEW)
    assert (found.gain_factor.values < own.gain_factor.values).any()


def test_a_law_of_higher_order_has_its_own_response():
    observer = fl.bench().evolve({"controller.kind": "limit_observer", "controller.model.resonance_hz": 132.0})
    found = check_fingers(observer, PEOPLE[:2], FEW)
    for k, person in enumerate(PEOPLE[:2]):
        every = corners(observer.evolve(person), ITSELF._replace(limits=FEW.limits))
        asked = [
            each for each in every if 0.5 <= round(each.loop.elements.force_n, 9) <= 0.7
        ]  # others count for nothing
        alone = max(asked, key=lambda each: each.excess)
        mine = found.isel(finger=k)
        assert mine.sensitivity_peak / mine.limit == pytest.approx(alone.excess, rel=0.01)


def test_what_was_found_on_fingers_is_told_with_the_worst_and_the_gains_for_all():
    light, weak = PEOPLE[1] | {"motion.load_n": 0.001}, PEOPLE[2] | {"friction.nominal_n": 0.1}
    found = check_fingers(PI, [PEOPLE[5], light, weak, weak], FEW)
    told = {each.code: each for each in of_fingers(found, lambda factor: {"controller.ki": factor * 20.0})}
    assert {"PEOPLE-HOLD", "PEOPLE-WORST", "PEOPLE-GAIN", "PEOPLE-UNSEEN"} <= set(told)
    assert (told["PEOPLE-HOLD"].value, told["PEOPLE-HOLD"].severity) == (0, "error")
    assert (told["PEOPLE-UNSEEN"].value, told["PEOPLE-UNSEEN"].more["fingers"]) == (3, 4)
    assert told["PEOPLE-UNSEEN"].more["reason"] == str(found.unseen.values[2])
    least = float(np.nanmin(found.gain_factor))
    assert told["PEOPLE-GAIN"].remedy == {"controller.ki": pytest.approx(20.0 * least)}
    assert told["PEOPLE-WORST"].where.finger == 0
    assert told["PEOPLE-WORST"].value == pytest.approx(float(np.nanmax(found.sensitivity_peak)))


def test_gains_for_nine_in_ten_are_told_beside_those_for_all():
    many = np.linspace(0.3, 0.75, 10)
    few = check_fingers(PI, PEOPLE[:1], FEW)
    found = few.isel(finger=np.zeros(10, int)).assign_coords(finger=np.arange(10))
    found = found.assign(gain_factor=("finger", many), holds=("finger", np.zeros(10, bool)), in_reach=found.holds)
    gains = [each for each in of_fingers(found, lambda factor: {}) if each.code == "PEOPLE-GAIN"]
    assert [(each.more["share"], each.value) for each in gains] == [(100.0, 0.3), (90.0, pytest.approx(many[1]))]


@pytest.mark.slow  # a design and two looks at people
def test_a_design_for_people_has_gains_that_hold_on_all_of_them():
    people, must = fl.fingers(6, 0), Requirements(slip_lengths_um=(11.5,))
    plain = controller(fl.bench(), "pi", must)
    many = check_fingers(plain.system, people, must)
    found = controller(fl.bench(), "pi", must, people)
    assert found.holds and bool(found.fingers["holds"].all()) and found.rows()[1][0] == "HOLDS"
    assert found.lowered_by == pytest.approx(float(many["gain_factor"].min()), rel=1e-3)
    assert found.lowered_by < 1.0
    assert float(found.fingers["gain_factor"].min()) == pytest.approx(1.0, rel=2e-3)
    (lowered,) = [each for each in found.findings if each.code == "LOWERED"]
    assert lowered.more == {"held": int(many["holds"].sum()), "fingers": 6}
    assert found.system.controller.ki == pytest.approx(found.lowered_by * plain.system.controller.ki, rel=1e-3)


def test_gains_too_small_to_be_felt_are_not_lowered_to(monkeypatch):
    hard = check_fingers(PI, PEOPLE[:3], FEW).assign(gain_factor=("finger", [0.8, 0.01, np.nan]))
    monkeypatch.setattr(controller_design, "check_fingers", lambda *_: hard)
    before = Designed({"controller.kind": "pi", "controller.kp": 0.0, "controller.ki": 40.0})
    found, factor, (why,) = controller_design._for_fingers(fl.bench(), before, PEOPLE[:3], FEW)
    assert found is before and factor == 1.0
    assert (why.code, why.value) == ("NOT-LOWERED", pytest.approx(0.4, rel=1e-3))


def test_ctrl_c_keeps_the_fingers_that_were_looked_at():
    class Stopped(list):
        def __iter__(self):
            yield from self[:2]
            raise KeyboardInterrupt

    with pytest.raises(FingersInterrupted) as stop:
        check_fingers(PI, Stopped(PEOPLE), FEW)
    assert stop.value.partial.identical(check_fingers(PI, PEOPLE[:2], FEW))
    with pytest.raises(KeyboardInterrupt) as at_once:
        check_fingers(PI, Stopped([PEOPLE[0] | {"motion.load_n": 0.001}] * 2), FEW)
    assert not isinstance(at_once.value, FingersInterrupted)


NOTCH = fl.bench().evolve({"controller.kind": "notch_pi", "setpoint": fl.Constant(offset_n=0.6)})
DRY = {"friction.occlusion_ratio": 1.0, "friction.moist_loss": 0.0}


def test_the_believed_finger_has_a_gain_of_one():
    assert loop_gain(NOTCH.evolve(DRY)) == pytest.approx(1.0, rel=1e-12)
    assert loop_gain(fl.bench().evolve({**DRY, "controller.kind": "limit_observer"})) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("finger", fl.fingers(8, 5))
def test_the_gain_is_what_a_command_does_to_the_force(finger):
    """dF/du by a difference of commands, through the table of the model and the finger's own law."""
    system = NOTCH.evolve({**finger, **DRY, "friction.susceptibility_per_um2": 0.5})
    law, model = law_at(system), system.controller.model

    def force(command_n):
        square = math.log(model.nominal_n / command_n) / model.susceptibility_per_um2
        return law.nominal_n * math.exp(-law.susceptibility_per_um2 * square)

    gain = loop_gain(system)
    if math.isnan(gain):
        assert not law.nominal_n * math.exp(-0.5 * 2.5**2) <= 0.6 <= law.nominal_n
        return
    square = math.log(law.nominal_n / 0.6) / law.susceptibility_per_um2
    u = model.nominal_n * math.exp(-model.susceptibility_per_um2 * square)
    assert force(u) == pytest.approx(0.6)
    assert gain == pytest.approx((force(u * 1.0001) - force(u * 0.9999)) / (0.0002 * u), rel=1e-6)


def test_the_share_is_that_of_fingers_looked_at_one_by_one():
    people, over = fl.fingers(40, 0), OperatingGrid()
    system = NOTCH.evolve({"controller.kp": 5.7, "controller.ki": 49.0, "controller.notch_hz": 134.0})
    found = loop_gains(system, over, people)
    each = check_fingers(system, people, Requirements(MOST_PEAK, 0.0, slip_lengths_um=()), progress=False)
    exact = float(np.mean(each["sensitivity_peak"].values > MOST_PEAK))
    assert found is not None and 0.0 < exact < 1.0
    # Two of forty: fingers near the limit differ by their skin and by how moist they get as well.
    assert found.share == pytest.approx(exact, abs=2 / 40)


def test_without_a_finger_or_a_loop_nobody_is_counted():
    assert loop_gains(fl.feasible(), OperatingGrid()) is None
    assert loop_gains(fl.bench().evolve({"controller.kind": "lookup"}), OperatingGrid()) is None


@pytest.mark.slow  # two designs
def test_a_design_bears_the_loop_gain_that_a_finger_may_have():
    bench = fl.bench()
    plain, strong = (controller(bench, "pi", Requirements(finger_gain=gain)) for gain in (1.0, 6.0))
    assert plain.people is not None and strong.people is not None and plain.people.critical < 6.0
    assert strong.people.critical == pytest.approx(6.0, rel=0.01) and strong.people.share < plain.people.share
    # The loop of a finger with that gain, by its own margins.
    factor = strong.people.critical / loop_gain(bench.evolve(dict(strong.overrides)))
    gains = {path: factor * strong.overrides[path] for path in ("controller.kp", "controller.ki")}
    peaks = [
        linearise(bench.evolve({**strong.overrides, **gains, "finger.slip_length_um": z}), force_n=force_n, occluded=w)
        for z in (11.5, 0.0) for force_n in (0.5, 0.7) for w in (0.0, moistest(bench.friction, bench.motion))
    ]  # fmt: skip
    assert max(each.sensitivity_peak() for each in peaks) == pytest.approx(MOST_PEAK, rel=0.01)


def test_what_is_measured_of_a_finger_is_in_what_the_controller_believes():
    assert fl.bench().controller.model.gain_spread == 2.7
    assert MeasuredFinger(Reach(0.1, 1.0), 0.4).changes["controller.model.gain_spread"] == 1.1
    measured = fl.bench().evolve({"controller.model.gain_spread": 1.1})
    assert (Requirements().gain_of(measured), Requirements(finger_gain=1.5).gain_of(measured)) == (1.1, 1.5)
    with pytest.raises(fl.FrictionloopError, match=r"^finger_gain = 0\.5: must be from 1 to 10"):
        Requirements(finger_gain=0.5)


def test_forces_out_of_reach_give_no_share():
    """A share of 0 would say that nobody rings where nothing was looked at."""
    far = fl.bench().evolve({"controller.kind": "pi", **fl.RETUNED, "setpoint": fl.Constant(offset_n=2.4)})
    assert loop_gains(far, OperatingGrid()) is None
