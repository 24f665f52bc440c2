"""Q, bandwidth and the beating envelope: closed forms, the resonance itself, a solver."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from frictionloop.hardware.plate.carrier import plate_resonator
from frictionloop.hardware.plate.envelope import (
    bandwidth_hz,
    detuned_gain,
    envelope,
    envelope_pole,
    quality_for_bandwidth,
    time_constant_s,
)
from frictionloop.parameters.plate_design import PlateDesign
from frictionloop.physics.plate import lowpass_step
from frictionloop.quantities import FrictionloopError, Lti

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


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf])
def test_a_bandwidth_is_positive(bad):
    with pytest.raises(FrictionloopError, match=r"^bandwidth_hz = .*: "):
        quality_for_bandwidth(F0, bad)


def test_a_bandwidth_as_wide_as_the_resonance_is_refused():
    with pytest.raises(FrictionloopError, match=r"^bandwidth_hz = 50000 Hz: must be below the resonance, 46000$"):
        quality_for_bandwidth(F0, 5e4)
