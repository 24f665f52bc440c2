"""A controller that is there: what `check_controller` says of it, and of less gain."""

from __future__ import annotations

import math

import numpy as np
import pytest
from designed_notch import DESIGNED_NOTCH

import frictionloop as fl
from frictionloop.analysis.margins import gain_factor
from frictionloop.design.checking import check_controller
from frictionloop.design.corners import broken, corners
from frictionloop.design.requirements import Requirements

LIMITS = Requirements().limits
PI = {"controller.kind": "pi", "controller.kp": 0.05, "controller.ki": 60.0}
ONE_PLACE = {"finger": {"kind": "rigid"}}
LIMIT_OBSERVER = {
    "controller.kind": "limit_observer",
    "controller.model.resonance_hz": 132.0,
    "controller.model.sensor_hz": 550.0,
}
"""Believing in springs below the true ones, as a design does."""
NYQUIST_HZ = 2500.0
GRID = np.linspace(1.0, 2499.0, 500)


@pytest.fixture(scope="module")
def checked():
    return check_controller(fl.bench().evolve(PI))


def test_the_factor_of_a_gain_that_is_real_and_of_one_that_turns():
    # |1 - k c| = 1/Ms first at k = (1 - 1/Ms)/c.
    found = gain_factor(lambda f: np.full(np.shape(f), -0.5 + 0j), GRID, NYQUIST_HZ, 2.0)
    assert found == pytest.approx((1.0 - 1.0 / 2.0) / 0.5)
    # G = exp(-j w) of constant size 1: -1 is reached at w = pi, and the circle of 1/Ms around it first there.
    turning = gain_factor(lambda f: np.exp(-2j * np.pi * np.asarray(f) / 1000.0), GRID, NYQUIST_HZ, 2.0)
    assert turning == pytest.approx(0.5, rel=1e-6)
    # A lag of first order never comes near.
    assert math.isinf(gain_factor(lambda f: 1 / (1 + 1j * np.asarray(f) / 100.0), GRID, NYQUIST_HZ, 1.5))


@pytest.mark.slow
def test_python_control_has_the_margins_of_a_corner(checked):
    """A dry slider is P S with the gain 1 of a model that is right, the resonance 10 % lower."""
    control = pytest.importorskip("control")
    system = fl.bench().evolve(PI)
    (place,) = [each for each in checked.places if (each.slip_length_um, each.speeds_mm_s) == (0.0, (20.0,))]
    (corner,) = [
        each
        for each in place.corners
        if each.off == -0.1 and each.loop.elements.occluded == 0.0 and each.loop.elements.force_n == pytest.approx(0.6)
    ]
    s, ts, m = control.tf("s"), 1.0 / 5000.0, system.sensor
    w = 2 * np.pi * 0.9 * m.resonance_hz
    plate = 1 / (1 + s * 2 * system.plate.q / (2 * np.pi * system.plate.frequency_hz))
    sensor = 1 / (1 + s / (m.q * w) + s**2 / w**2) / (1 + s / (2 * np.pi * m.cutoff_hz))
    held = control.sample_system(control.ss(plate * sensor), ts, "zoh") * control.ss(0, 1, 1, 0, ts)  # 200 us: a period
    kp, ki = PI["controller.kp"], PI["controller.ki"]
    series = control.ss(control.tf([kp, ki * ts - kp], [1, -1], ts)) * held
    assert (np.abs(control.feedback(series).poles()) < 1).all()
    G = series(np.exp(2j * np.pi * np.union1d(np.arange(0.5, 2499, 0.1), np.arange(100, 160, 0.002)) * ts))
    assert corner.sensitivity_peak == pytest.approx(np.max(1 / np.abs(1 + G)), rel=1e-4)
    real = G.real[:-1][(np.diff(np.sign(G.imag)) != 0) & (G.real[:-1] < 0)]  # its own margins lose digits here
    assert corner.margins.gain_margin == pytest.approx(min(-1 / real, key=lambda k: abs(np.log(k))), rel=1e-3)
    factor = corner.loop.gain_factor(corner.limit)
    assert np.max(1 / np.abs(1 + factor * G)) == pytest.approx(corner.limit, rel=1e-4)


@pytest.mark.slow
def test_gains_that_ring_on_a_slider_are_said_not_to_hold_with_those_that_do(checked):
    assert not checked.holds
    assert {place.how for place in checked.places if place.slip_length_um == 0.0} == {"unstable"}
    assert checked.instead["controller.ki"] / checked.instead["controller.kp"] == pytest.approx(1200.0, rel=1e-3)
    less = check_controller(fl.bench().evolve({**PI, **checked.instead}))
    assert less.holds and less.instead == {}
    assert min(less.gains) == pytest.approx(1.0, abs=0.005)  # and hardly more would


@pytest.mark.slow
def test_less_gain_never_turns_what_holds_into_what_does_not(checked):
    slider = fl.bench().evolve({**PI, "finger.slip_length_um": 0.0})
    for share in (1.0, 0.83, 0.31, 0.07, 0.002):
        gains = {path: share * value for path, value in checked.instead.items()}
        assert broken(corners(slider.evolve(gains), LIMITS)) is None
    more = {path: 1.02 * value for path, value in checked.instead.items()}
    assert broken(corners(slider.evolve(more), LIMITS)) is not None


def test_a_place_may_hold_where_another_does_not(checked):
    for place, gain in zip(checked.places, checked.gains, strict=True):
        assert (gain >= 0.999) == (place.how == "within")


def test_the_table_lookup_has_no_loop():
    found = check_controller(fl.bench().evolve({**ONE_PLACE, "controller.kind": "lookup"}))
    assert found.holds and found.gains == (math.inf,)
    assert "does not use the force" in found.notes[0]


def test_a_force_out_of_reach_is_refused_as_by_a_design():
    with pytest.raises(fl.FrictionloopError, match="saturation is the limit"):
        check_controller(fl.bench().evolve({"setpoint.offset_n": 2.0}))


@pytest.mark.slow
def test_a_limit_observer_gets_a_margin_that_holds():
    there = fl.bench().evolve({**ONE_PLACE, **LIMIT_OBSERVER, "controller.susceptibility_margin": 0.5})
    found = check_controller(there)
    assert not found.holds
    assert 0.5 < found.instead["controller.susceptibility_margin"] < 2.0
    assert check_controller(there.evolve(dict(found.instead))).holds


@pytest.mark.slow
@pytest.mark.parametrize("law", [DESIGNED_NOTCH, {"controller.kind": "filtered_pi", "controller.feedforward": True}])
def test_the_gain_of_a_law_with_filters_is_that_of_kp_and_ki(law):
    there = fl.bench().evolve({**ONE_PLACE, **law})
    found = check_controller(there)
    factor = 0.9 * min(found.gains)
    gains = {f"controller.{name}": factor * getattr(there.controller, name) for name in ("kp", "ki")}
    assert min(check_controller(there.evolve(gains)).gains) == pytest.approx(1.0 / 0.9, rel=1e-5)
