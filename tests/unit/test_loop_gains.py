"""The loop gain of other people: against a derivative, and against a look at each finger's own loop."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis.operating import law_at
from frictionloop.design.loop_gains import MOST_PEAK, loop_gain, loop_gains
from frictionloop.design.on_fingers import check_fingers
from frictionloop.design.over import Over
from frictionloop.design.wanted import Wanted

NOTCH = fl.bench().evolve({"controller.kind": "notch_pi", "setpoint": fl.Constant(offset_n=0.6)})
DRY = {"friction.occlusion_ratio": 1.0, "friction.moist_loss": 0.0}


def test_the_believed_finger_has_a_gain_of_one():
    assert loop_gain(NOTCH.evolve(DRY)) == pytest.approx(1.0, rel=1e-12)
    assert loop_gain(fl.bench().evolve({**DRY, "controller.kind": "limit_observer"})) == pytest.approx(0.5, rel=1e-12)


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
    people, over = fl.fingers(40, 0), Over()
    system = NOTCH.evolve({"controller.kp": 5.7, "controller.ki": 49.0, "controller.notch_hz": 134.0})
    found = loop_gains(system, over, people)
    each = check_fingers(system, people, Wanted(MOST_PEAK, 0.0, slip_lengths_um=()), progress=False)
    exact = float(np.mean(each["sensitivity_peak"].values > MOST_PEAK))
    assert found is not None and 0.0 < exact < 1.0
    # Two of forty: fingers near the limit differ by their skin and by how moist they get as well.
    assert found.share == pytest.approx(exact, abs=2 / 40)


def test_without_a_finger_or_a_loop_nobody_is_counted():
    assert loop_gains(fl.feasible(), Over()) is None
    assert loop_gains(fl.bench().evolve({"controller.kind": "lookup"}), Over()) is None
