"""Overdrive against the plate in closed form: what a first-order lag can be given in a period, and no more."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.control.lookup import overdrive_gains, overdrive_step

TS, PLATE_HZ, LARGEST_UM = 2e-4, 100.0, 2.5
LEFT = math.exp(-2.0 * math.pi * PLATE_HZ * TS)
"""Share of a difference that the plate's lag leaves after a period."""
GAINS = overdrive_gains(fl.LookupController(overdrive=True))


@given(st.floats(0.0, LARGEST_UM), st.floats(-10.0, 10.0))
def test_the_plate_goes_to_what_is_wanted_or_as_near_as_a_period_lets_it(amplitude_um, wanted_um):
    """Commands from 0 to a_max reach p a to p a + (1 - p) a_max; the belief is the lag's answer to what is given."""
    believed, command = overdrive_step(amplitude_um, wanted_um, GAINS)
    assert 0.0 <= command <= LARGEST_UM
    assert believed == pytest.approx(command + (amplitude_um - command) * LEFT, abs=1e-14)
    lowest, highest = LEFT * amplitude_um, LARGEST_UM - LEFT * (LARGEST_UM - amplitude_um)
    assert believed == pytest.approx(min(max(wanted_um, lowest), highest), abs=1e-13)


def test_a_leap_takes_the_least_time_that_the_drive_allows():
    """Full drive up, none down, until the level is reached, then the level: the plate's own amplitude, each period."""
    levels_n = (0.8, 0.1, 0.7, 0.8)
    steps = fl.Steps(times_s=(0.0, 0.01, 0.03, 0.04), levels_n=levels_n)
    system = fl.paper().evolve(
        {"controller": {"kind": "lookup", "overdrive": True}, "setpoint": steps, "disturbance": fl.Constant(offset_n=0)}
    )
    run = fl.simulate(system, 0.06)
    exact, wanted_um = [0.0], np.sqrt(np.log(0.8 / run["f_r"].values) / 0.38)
    for wanted in wanted_um[:-1]:
        before = exact[-1]
        full, none = LARGEST_UM + (before - LARGEST_UM) * LEFT, before * LEFT
        exact.append(min(wanted, full) if wanted > before else max(wanted, none))
    assert np.count_nonzero(np.abs(exact - np.roll(wanted_um, 1)) > 0.01) > 30  # most leaps take many periods
    np.testing.assert_allclose(run["a"].values, exact, rtol=0, atol=1e-9)
