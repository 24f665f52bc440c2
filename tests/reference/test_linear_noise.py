"""Equation (3): the variance, the integral over the spectrum, and the printed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linear_runs import integrated_noise_rms_n, noise_spectrum, run_linear

from frictionloop.analysis import command_noise_rms_n, equation_3_rms_n, kp_limit, linearise, output_noise_rms_n
from frictionloop.parameters import paper


@settings(max_examples=25, deadline=None)
@given(share=st.floats(0.02, 0.98), ki=st.floats(0.01, 500), delay_s=st.one_of(st.just(0.0), st.floats(0, 1e-3)))
def test_variance_equals_the_integral_of_the_spectrum(share: float, ki: float, delay_s: float) -> None:
    system = paper().evolve({"controller.ki": ki, "controller.delay_s": delay_s})
    limit = kp_limit(system)
    if math.isnan(limit):
        return
    system = system.evolve({"controller.kp": share * limit})
    if not linearise(system).is_stable():
        return  # much ki needs some kp too
    assert integrated_noise_rms_n(linearise(system)) == pytest.approx(output_noise_rms_n(system), rel=1e-6)
    assert integrated_noise_rms_n(linearise(system), "u") == pytest.approx(command_noise_rms_n(system), rel=1e-6)


def test_variance_equals_the_sum_of_the_squared_impulse_response() -> None:
    system = paper().evolve({"controller.kp": 5.0, "controller.ki": 200.0, "controller.delay_s": 1.3e-4})
    impulse = np.zeros((20_000, 3))
    impulse[0, 2] = system.sensor.noise_rms_n
    rows = run_linear(linearise(system).state_space(), impulse)
    assert output_noise_rms_n(system) == pytest.approx(math.sqrt(np.sum(rows[:, 0] ** 2)), rel=1e-9)
    assert command_noise_rms_n(system) == pytest.approx(math.sqrt(np.sum(rows[:, 2] ** 2)), rel=1e-9)


def test_long_delay() -> None:
    system = paper().evolve({"controller.kp": 0.3, "controller.ki": 5.0, "controller.delay_s": 6.1e-3})
    assert integrated_noise_rms_n(linearise(system)) == pytest.approx(output_noise_rms_n(system), rel=1e-8)


def test_next_to_instability() -> None:
    """A pole 1e-7 from the unit circle makes a peak 1e-4 Hz wide, which the panels must not step over."""
    system = paper().evolve({"controller.kp": kp_limit(paper()) * (1 - 1e-6)})
    # The distance of the pole itself is known to 1e-16 / 1e-7 = 1e-9 at best, a few times that after rounding.
    assert integrated_noise_rms_n(linearise(system)) == pytest.approx(output_noise_rms_n(system), rel=1e-7)


def test_printed_integral_in_closed_form() -> None:
    """Ki = 0: |T|^2 = kp^2 / |(1 + s/wc)(1 + s/ws) + kp|^2, integrated by residues when the band is endless.

    Integral over all f of |b0 / (s^2 + a1 s + a0)|^2 is b0^2 / (2 a0 a1); a rate of 10 MHz is endless enough:
    the tail beyond 5 MHz falls as f^-4.
    """
    kp, wc, ws, sigma, rate = 10.0, 2 * np.pi * 100, 2 * np.pi * 1000, 1e-5, 1e7
    system = paper().evolve({"controller.ki": 0.0, "controller.rate_hz": rate})
    both_sides = (kp * wc * ws) ** 2 / (2 * (1 + kp) * wc * ws * (wc + ws))
    expected = sigma * math.sqrt(both_sides / rate)
    assert integrated_noise_rms_n(linearise(system), reading="printed") == pytest.approx(expected, rel=1e-6)


def test_printed_form_is_the_response_to_a_tone() -> None:
    system = paper()
    T = linearise(system).responses([3.0, 300.0], "printed")["T"]
    np.testing.assert_allclose(equation_3_rms_n(system, [3.0, 300.0]), np.abs(T) * 1e-5, rtol=1e-12)


def test_spectrum_integrates_to_the_variance() -> None:
    """A trapezoidal rule over a periodic, smooth spectrum converges geometrically."""
    system = paper().evolve({"controller.ki": 300.0})
    frequency = (np.arange(50_000) + 0.5) * 0.05
    total = float(np.sum(noise_spectrum(linearise(system), frequency, "f_a")) * 0.05)
    assert math.sqrt(total) == pytest.approx(output_noise_rms_n(system), rel=1e-9)


def test_noise_scales_and_vanishes() -> None:
    loud = paper().evolve({"sensor.noise_rms_n": 1e-3})
    assert output_noise_rms_n(loud) == pytest.approx(100 * output_noise_rms_n(paper()), rel=1e-12)
    assert output_noise_rms_n(paper().evolve({"sensor.noise_rms_n": 0.0})) == 0.0
    assert output_noise_rms_n(paper().evolve({"controller.kp": 0.0, "controller.ki": 0.0})) == 0.0


def test_an_unstable_loop_has_no_finite_noise() -> None:
    system = paper().evolve({"controller.kp": 40.0})
    assert output_noise_rms_n(system) == math.inf
