"""The loop gain of other people: against a derivative, and against a look at each finger's own loop."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis.linear import linearise
from frictionloop.analysis.operating import law_at, moistest
from frictionloop.design.controller_design import controller
from frictionloop.design.loop_gains import MOST_PEAK, loop_gain, loop_gains
from frictionloop.design.operating_grid import OperatingGrid
from frictionloop.design.population_margins import check_fingers
from frictionloop.design.requirements import Requirements
from frictionloop.experiments.measured_finger import MeasuredFinger
from frictionloop.physics.reach import Reach

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
