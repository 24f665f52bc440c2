"""One controller on many fingers: each as one check would find it, and gains that hold on all."""

from __future__ import annotations

import re

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli.check_fingers import _room, lowered_rows, rows
from frictionloop.design.corners import MET, band_of, corners
from frictionloop.design.on_fingers import FingersInterrupted, check_fingers
from frictionloop.design.requirements import Requirements

PI = fl.bench().evolve({"controller.kind": "pi", "controller.kp": 0.03, "controller.ki": 20.0})
PEOPLE = fl.fingers(8, 0)
FEW = Requirements(slip_lengths_um=(), resonance_error=0.05)


@pytest.mark.slow
def test_each_finger_is_as_a_check_of_it_alone_finds_it():
    found = check_fingers(PI, PEOPLE[:4], FEW)
    for k, person in enumerate(PEOPLE[:4]):
        alone = corners(PI.evolve(person), FEW.limits, FEW.over(3, 2))
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
    with pytest.raises(fl.FrictionloopError, match=r"no finger can be looked at; the first: motion.load_n = 0.001"):
        check_fingers(PI, people[1:], FEW)
    with pytest.raises(fl.FrictionloopError, match=r"people: needs one finger"):
        check_fingers(PI, [], FEW)


def test_forces_out_of_a_fingers_reach_are_told():
    strong, weak = (PEOPLE[0] | {"friction.nominal_n": nominal_n} for nominal_n in (0.95, 0.3))
    found = check_fingers(PI, [strong, weak], FEW)
    assert "no force asked for is in reach" in str(found.unseen.values[1]) and not found.holds.values[1]
    there = [loop.elements for loop in band_of(PI.evolve(strong))]
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
        every = corners(observer.evolve(person), FEW.limits)
        asked = [
            each for each in every if 0.5 <= round(each.loop.elements.force_n, 9) <= 0.7
        ]  # others count for nothing
        alone = max(asked, key=lambda each: each.excess)
        mine = found.isel(finger=k)
        assert mine.sensitivity_peak / mine.limit == pytest.approx(alone.excess, rel=0.01)


def test_gains_for_all_name_how_many_were_looked_at_and_each_reason_why_others_were_not():
    light, weak = PEOPLE[1] | {"motion.load_n": 0.001}, PEOPLE[2] | {"friction.nominal_n": 0.1}
    found = check_fingers(PI, [PEOPLE[5], light, weak, weak], FEW)
    said = " ".join(" ".join(row) for row in rows(found, PI, "seed 0", "slip length 11.5 um", ""))
    assert said.startswith("NOT ON ALL FINGERS the limits hold on 0 of 1 that can be looked at, of 4 fingers of seed 0")
    assert "3 cannot be looked at: 2 as no force asked for" in said
    assert "1 as motion.load_n = 0.001 N" in said and "on all 1 the limits hold with" in said
    calm = PI.evolve({"controller.kp": 0.0, "controller.ki": 2.0})
    found = check_fingers(calm, [PEOPLE[5], light, weak, weak], FEW)
    said = " ".join(" ".join(row) for row in rows(found, calm, "seed 0", "slip length 11.5 um", ""))
    assert said.startswith("on fingers the limits hold on all 1 that can be looked at, of 4 fingers of seed 0")


def test_gains_for_those_who_can_be_served_are_named_where_others_need_less():
    found = check_fingers(PI, PEOPLE[:3], FEW).assign(gain_factor=("finger", [0.3, 0.6, 0.8]))

    def said(*reached: bool) -> str:
        here = found.assign(in_reach=("finger", list(reached)))
        return " ".join(" ".join(row) for row in rows(here, PI, "seed 0", "slip length 11.5 um", ""))

    assert "1 cannot be given" in said(False, True, True)
    assert "; it cannot be given every force asked for" in said(False, True, True)  # the worst finger, the first
    assert "; it cannot be given every force asked for" not in said(True, False, False)
    assert re.search("on the 2 others the limits hold with `[^`]+`, 0.6 times the gain", said(False, True, True))
    assert "2 cannot be given" in said(True, False, False) and "others the limits" not in said(True, False, False)
    assert "others the limits" not in said(True, True, True)


def test_a_design_that_was_lowered_says_which_gains_those_who_can_be_served_bear():
    found = check_fingers(PI, PEOPLE[:3], FEW).assign(in_reach=("finger", [False, True, True]))

    def said(*factors: float) -> str:
        here = found.assign(gain_factor=("finger", list(factors)))
        return " ".join(" ".join(row) for row in lowered_rows(here, PI, 0.5, "seed 0", "slip length 11.5 um", ""))

    assert "on the 2 others the limits hold with the gains for the finger of the file" in said(0.5, 1.3, 2.0)
    assert re.search("on the 2 others the limits hold with `[^`]+`, 0.8 times those", said(0.5, 0.8, 2.0))
    assert "others the limits" not in said(0.5, 0.501, 2.0)


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


@pytest.mark.parametrize(
    ("gain", "said"), [(1.0, "with a higher gain"), (1.91, "may be 1.91 times as high"), (np.inf, "")]
)
def test_what_is_said_of_the_room_that_is_left_on_all_fingers(gain, said):
    told = _room(gain)
    assert said in told and "∞" not in told and " 1 times" not in told and bool(told) == bool(said)
