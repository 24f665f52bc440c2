"""Amplitudes that pulses of whole clock ticks can give, alone and in the loop."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.hardware.plate.carrier_pwm import duty_for, pulse_ticks, share_of
from frictionloop.physics.plate import pulse_step


@given(st.floats(-1.0, 5.0), st.floats(0.1, 5.0), st.integers(4, 2000))
def test_it_is_the_carrier_with_the_nearest_pulse(command, largest, ticks):
    """The carrier's own formulas, which the plate's spectra are made with, say the same."""
    got = pulse_step(command, largest, float(ticks))
    width = round(float(np.arcsin(min(got / largest, 1.0))) / np.pi * ticks)
    assert got == pytest.approx(largest * float(share_of(width, ticks)), abs=1e-12 * largest)
    wanted = float(duty_for(command / largest)) * ticks
    assert abs(wanted - width) <= 0.5 + 1e-6 or width == ticks // 2
    assert width in (int(pulse_ticks(command / largest, ticks)), round(wanted - 1e-9), round(wanted + 1e-9))


@given(st.integers(0, 391))
def test_what_pulses_can_give_stays(width):
    a = 2.5 * np.sin(np.pi * width / 783)
    assert pulse_step(a, 2.5, 783.0) == pytest.approx(a, abs=1e-12)


def test_a_run_has_only_the_amplitudes_of_its_pulses():
    """A plate that is quick beside the period is at its command: of 8 ticks, at one of 5 amplitudes."""
    quick = fl.paper().evolve({"plate.cutoff_hz": 2e4, "plate.pulse_ticks": 8})
    run = fl.simulate(quick, duration_s=0.5)
    levels = 2.5 * np.sin(np.pi * np.arange(5) / 8)
    off = np.min(np.abs(run.a.to_numpy()[:, None] - levels), axis=1)
    assert np.median(off) < 1e-6 and len(np.unique(np.round(run.a.to_numpy(), 5))) < 60


def test_more_ticks_than_the_loop_can_tell_change_nothing():
    system = fl.feasible()
    fine = fl.simulate(system.evolve({"plate.pulse_ticks": 65536}), duration_s=1.0)
    whole = fl.simulate(system.evolve({"controller.form": "float"}), duration_s=1.0)
    assert float(np.abs(fine.f_a - whole.f_a).max()) < 1e-3


def test_three_ticks_are_refused():
    with pytest.raises(fl.FrictionloopError, match=r"plate\.pulse_ticks.*0 .*or at least 4"):
        fl.paper().evolve({"plate.pulse_ticks": 3})
