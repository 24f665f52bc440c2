"""Q, bandwidth and the beating envelope: closed forms, the resonance itself, a solver."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import frictionloop as fl
from frictionloop.hardware.plate.carrier_simulation import plate_resonator
from frictionloop.hardware.plate.drive_requirements import (
    amplitude_left,
    bandwidth_hz,
    detuned_gain,
    envelope,
    envelope_pole,
    finger_effect,
    mode_factor,
    quality_for_bandwidth,
    time_constant_s,
)
from frictionloop.parameters.plate_design import PlateDesign
from frictionloop.physics.plate import limit_step, linearise_plate, lowpass_step
from frictionloop.quantities import Lti

F0, Q = 46e3, 230.0


def test_100_hz_needs_q_230_at_46_khz():
    assert quality_for_bandwidth(46e3, 100.0) == 230.0
    assert bandwidth_hz(46e3, 230.0) == pytest.approx(100.0, rel=1e-14)
    assert quality_for_bandwidth(30e3, 100.0) == 150.0  # the carrier of Fig. 1a
    assert PlateDesign().drive.quality_factor == 230.0


@given(st.floats(1e3, 1e6), st.floats(1.0, 1e5))
def test_the_envelope_is_the_decay_of_the_resonance(f0, q):
    pole = plate_resonator(f0, q).poles[0]
    assert -1 / pole.real == pytest.approx(time_constant_s(f0, q), rel=1e-9)
    # The damped resonance lies w0 (1 - sqrt(1 - 1/(4 Q^2))) < w0/(7 Q^2) lower, which the envelope leaves out.
    assert 0 <= 2 * math.pi * f0 - abs(pole.imag) <= 2 * math.pi * f0 / (7 * q * q) + 1e-9 * f0


def test_the_first_order_envelope_is_the_loops():
    """Tuned, the model is the step function that the loop's plate uses."""
    command = np.array([2.5, 2.5, 0.3, 0.0, 1.7])
    found = envelope(command, 2e-4, envelope_pole(F0, Q))
    a, decay = 0.0, math.exp(-2 * math.pi * bandwidth_hz(F0, Q) * 2e-4)
    for k, c in enumerate(command):
        assert found[k] == pytest.approx(a, abs=1e-14)
        a = lowpass_step(a, c, decay)
    assert found[-1] == pytest.approx(a, abs=1e-14)


@given(st.floats(-500, 500), st.floats(20, 1000))
def test_a_detuned_envelope_settles_and_beats(detuning, q):
    pole = envelope_pole(F0, q, detuning)
    gain = detuned_gain(F0, q, detuning)
    exact = plate_resonator(F0, q).response(F0 + detuning)
    # Narrow-band approximation of the resonance: relative error of the order df/f0 and 1/(2Q).
    assert gain == pytest.approx(abs(exact), rel=abs(detuning) / F0 + 1 / (2 * q))
    time = np.arange(2001) * 1e-5
    found = envelope(np.ones(2000), 1e-5, pole)
    closed = pole.real / pole * (1 - np.exp(pole * time))
    np.testing.assert_allclose(found, closed, rtol=0, atol=1e-11)


def test_a_solver_gives_the_same_envelope():
    pole, step = envelope_pole(F0, Q, 120.0), 1e-3
    command = np.array([1.0, 0.2, 0.9])

    def slope(t, a):
        return pole * a - pole.real * command[min(int(t / step), 2)]

    a = np.array([0.3j])
    found = envelope(command, step, pole, start=0.3j)
    for k in range(3):
        a = solve_ivp(slope, (k * step, (k + 1 - 1e-12) * step), a, rtol=1e-10, atol=1e-12).y[:, -1]
        assert found[k + 1] == pytest.approx(a[0], abs=1e-8)


def linearised(detuning_hz):
    """H(s) = (s1/m) (s1 s + m^2)/((s + s1)^2 + w1^2), m^2 = s1^2 + w1^2: |A| over small changes of the command."""
    pole = envelope_pole(F0, Q, detuning_hz)
    rate, size = -pole.real, abs(pole)
    return Lti((rate * rate / size, rate * size), (1.0, 2 * rate, size * size))


@pytest.mark.parametrize("detuning", [0.0, 50.0, -130.0])
@pytest.mark.parametrize("frequency", [1.0, 60.0, 130.0, 400.0])
def test_small_changes_of_the_amplitude(detuning, frequency):
    """|A| under c = 1 + eps cos(2 pi f t), its component at f by correlation, against the linearisation."""
    pole, steps = envelope_pole(F0, Q, detuning), 4000
    step, eps = 1 / (frequency * steps), 1e-5
    settle = math.ceil(25 * time_constant_s(F0, Q) * frequency)
    phase = 2 * np.pi * (np.arange((settle + 1) * steps) + 0.5) / steps
    amplitude = np.abs(envelope(1 + eps * np.cos(phase), step, pole))[-steps - 1 : -1]
    found = 2 * np.mean(amplitude * np.exp(-2j * np.pi * np.arange(steps) / steps)) / eps
    # Held commands: (2 pi/steps)^2/24 = 1e-7; squares of eps: 1e-5; settled to e^-25.
    exact = linearised(detuning).response(frequency)
    assert found == pytest.approx(exact, rel=1e-4)


def test_poles_of_the_linearisation():
    lti = linearised(50.0)
    pole = envelope_pole(F0, Q, 50.0)
    assert pole == complex(-1 / time_constant_s(F0, Q), -2 * math.pi * 50.0)
    np.testing.assert_allclose(
        np.sort_complex(np.roots(lti.den)), np.sort_complex([pole, pole.conjugate()]), rtol=1e-12
    )
    assert abs(lti.response(0.0)) == pytest.approx(detuned_gain(F0, Q, 50.0), rel=1e-13)
    tuned = linearised(0.0)
    assert abs(tuned.response(100.0)) == pytest.approx(math.sqrt(0.5), rel=1e-13)


# The plate's envelope: step and frequency response of a first-order low-pass, and what the drive can do.


PLATE = fl.paper().plate
OMEGA = 2 * math.pi * PLATE.cutoff_hz


@given(st.floats(0, 2.5), st.floats(0, 2.5), st.lists(st.floats(1e-6, 1e-2), min_size=1, max_size=20))
def test_held_commands_follow_the_exponential_whatever_the_steps(start, command, pieces):
    a = start
    for h in pieces:
        a = lowpass_step(a, command, math.exp(-OMEGA * h))
    exact = command + (start - command) * math.exp(-OMEGA * sum(pieces))
    # Each piece rounds twice at the size of a, and the decay once.
    assert a == pytest.approx(exact, abs=4 * len(pieces) * 2.0**-52 * 2.5)


@given(st.floats(0, 2.5), st.floats(0, 2.5), st.floats(0, 1))
def test_the_amplitude_stays_between_where_it_was_and_the_command(start, command, decay):
    a = lowpass_step(start, command, decay)
    slack = 2.0**-52 * max(start, command)
    assert min(start, command) - slack <= a <= max(start, command) + slack


def test_the_drive_is_limited():
    for command, limited in [(-1.0, 0.0), (0.0, 0.0), (1.3, 1.3), (2.5, 2.5), (3.0, 2.5), (math.inf, 2.5)]:
        assert limit_step(command, 2.5) == limited


def test_a_held_command_through_the_simulator():
    """With kp = ki = 0 the command is a_max from the first sample: a(t) = a_max (1 - e^(-wc t))."""
    system = fl.paper().evolve({"controller.kp": 0.0, "controller.ki": 0.0})
    run = fl.simulate(system, 0.1)
    exact = -2.5 * np.expm1(-OMEGA * run["time"].values)
    # 500 periods, each rounding a few times at the size of 2.5 um, less what the pole forgets: below 1e-14.
    np.testing.assert_allclose(run["a"].values, exact, rtol=0, atol=1e-14)


def test_frequency_response():
    plate = linearise_plate(PLATE)
    assert plate.response(0.0) == 1.0
    assert abs(plate.response(100.0)) == pytest.approx(math.sqrt(0.5), rel=1e-14)
    assert np.angle(plate.response(100.0)) == pytest.approx(-math.pi / 4, rel=1e-14)
    assert abs(plate.response(1e6)) == pytest.approx(1e-4, rel=1e-7)  # -20 dB per decade


# A finger on the plate: damping and the ripple along a stroke.


HALF_MM = 140 / 11.5


def effect(plate, finger, contact):
    """What a finger changes on a plate of Q 230."""
    touched = {"finger.resistance_n_s_per_m": finger, "finger.contact_mm": contact, "drive.quality_factor": 230.0}
    return finger_effect(PlateDesign().evolve(touched), plate, HALF_MM)


@given(st.floats(-30, 30), st.floats(3, 30), st.floats(0.5, 25))
def test_the_mode_factor_is_the_mean_over_the_disc(position, half_mm, contact):
    """Chords of the disc, weighted by their length; Gauss-Chebyshev nodes of the second kind are exact for them."""
    n = np.arange(1, 201)
    angle = n * np.pi / 201
    x, weight = position + contact / 2 * np.cos(angle), np.sin(angle) ** 2
    direct = np.sum(weight * np.cos(np.pi / half_mm * x) ** 2) / np.sum(weight)
    assert mode_factor(position, half_mm, contact) == pytest.approx(direct, abs=1e-12)


@given(st.floats(-30, 30), st.floats(3, 30), st.floats(0.5, 25))
def test_the_ripple_has_the_period_of_half_a_wavelength(position, half_mm, contact):
    here = mode_factor(position, half_mm, contact)
    assert mode_factor(position + half_mm, half_mm, contact) == pytest.approx(here, abs=1e-12)
    assert mode_factor(position + half_mm / 2, half_mm, contact) == pytest.approx(1 - here, abs=1e-12)
    assert 0 <= here <= 1


def test_a_point_feels_the_mode_itself_and_a_large_contact_its_mean():
    x = np.linspace(0, 12, 7)
    np.testing.assert_allclose(mode_factor(x, HALF_MM, 1e-4), np.cos(np.pi * x / HALF_MM) ** 2, atol=1e-9)
    np.testing.assert_allclose(mode_factor(x, HALF_MM, 1e4), 0.5, atol=1e-4)


def test_figures_of_the_research_notes():
    """Notes C.5: at Q 230 a finger of 55 N s/m leaves 0.86 and Q 198, at Q 500 it leaves 0.74; ripple 10 to 20 %."""
    found = effect(168.0, 55.0, 10.0)
    assert found.amplitude_on_touch == pytest.approx(0.86, abs=5e-3)
    assert found.quality_on_touch == pytest.approx(198, abs=0.5)
    assert amplitude_left(0.5, 168.0 * 230 / 500, 55.0) == pytest.approx(0.74, abs=5e-3)
    assert 0.10 < found.felt_ripple < 0.20
    assert found.plate_ripple < found.felt_ripple


@given(st.floats(1, 1000), st.floats(0, 500), st.floats(0, 1))
def test_damping_adds_up(plate, finger, factor):
    """Amplitude goes as 1/damping at the same drive, and so does Q."""
    left = amplitude_left(factor, plate, finger)
    assert 0 < left <= 1
    assert left * (plate + factor * finger) == pytest.approx(plate, rel=1e-12)


@given(st.floats(1, 1000), st.floats(0, 500), st.floats(1, 20))
def test_the_ripple_of_the_plate_in_closed_form(plate, finger, contact):
    """Amplitudes 1/(R_p + R_f (1 +- s)/2) differ by R_f s/2 over their mean R_p + R_f/2."""
    spread = abs(float(mode_factor(0.0, HALF_MM, contact)) - 0.5)
    found = effect(plate, finger, contact)
    assert found.plate_ripple == pytest.approx(finger * spread / (plate + finger / 2), abs=1e-9)


def test_without_a_finger_only_the_mode_itself_is_felt():
    found = effect(168.0, 0.0, 10.0)
    assert found.amplitude_on_touch == 1.0
    assert found.plate_ripple == 0.0
    high, low = (math.sqrt(float(mode_factor(x, HALF_MM, 10.0))) for x in (0.0, HALF_MM / 2))
    assert found.felt_ripple == pytest.approx((high - low) / (high + low), rel=1e-9)
