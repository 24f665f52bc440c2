"""Tremor: exact for a held drive, stationary from its first sample, peak and width where they were asked for."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit
from scipy.integrate import solve_ivp
from scipy.linalg import solve_discrete_lyapunov
from scipy.signal import welch

from frictionloop.physics.tremor import TremorState, tremor_coefficients, tremor_start, tremor_step
from frictionloop.quantities.counter_noise import normals

DT = 2e-4
RMS_M = 30e-6
TREMOR = tremor_coefficients(RMS_M, 10.0, 4.0, DT)
frequency, width = st.floats(2, 50), st.floats(0.1, 50)


@njit
def tremble(x, rate, drive, coefficients):
    out = np.empty((drive.size, 2))
    state = TremorState(x, rate)
    for k in range(drive.size):
        out[k] = state
        state = tremor_step(state, drive[k], coefficients)
    return out


@njit
def tremble_lanes(x, rate, drive, coefficients):
    for i in range(x.size):
        x[i], rate[i] = tremor_step((x[i], rate[i]), drive[i], coefficients)


def resonance(peak, b):
    """A and B of d/dt (x, x') = A (x, x') + B u."""
    omega2 = (2 * math.pi * peak) ** 2 + 2 * (math.pi * b) ** 2
    return np.array([[0.0, 1.0], [-omega2, -2 * math.pi * b]]), np.array([0.0, 1.0])


def covariance(a, drive):
    """P = A P A' + b b', solved for x and x'/w, which are of one size."""
    scale = np.array([1.0, math.sqrt(-a[1, 0] / a[0, 1])])
    there, back = np.outer(scale, 1 / scale), np.outer(scale, scale)
    p = solve_discrete_lyapunov(a / there, np.outer(drive / scale, drive / scale), method="bilinear")
    return p * back


def response(f, peak, b):
    a, drive = resonance(peak, b)
    s = 2j * np.pi * f[:, None, None] * np.eye(2)
    return np.abs(np.linalg.solve(s - a, np.broadcast_to(drive[:, None], (f.size, 2, 1)))[:, 0, 0]) ** 2


@given(frequency, width, st.floats(1e-6, 1))
@settings(max_examples=50)
def test_the_stationary_covariance_is_kept(f, b, rms):
    c = tremor_coefficients(rms, f, b, DT)
    a, drive = np.array([[c.a11, c.a12], [c.a21, c.a22]]), np.array([c.b1, c.b2])
    p = covariance(a, drive)
    scale = np.sqrt(np.outer(np.diag(p), np.diag(p)))
    np.testing.assert_allclose((a @ p @ a.T + np.outer(drive, drive)) / scale, p / scale, rtol=0, atol=1e-12)
    assert math.sqrt(p[0, 0]) == pytest.approx(rms, rel=1e-9)
    # White noise gives sigma_v = w sigma_x; held for dt it lacks what lies above 1/dt.
    omega = math.sqrt(-resonance(f, b)[0][1, 0])
    assert math.sqrt(p[1, 1]) == pytest.approx(omega * rms, rel=2 * omega * DT)


def test_rms_against_the_sum_of_the_impulse_response():
    # Variance of a filter fed with unit white noise: the sum of its squared impulse response.
    drive = np.zeros(20_000)
    drive[0] = 1.0
    response = tremble(0.0, 0.0, drive, TREMOR)
    assert math.sqrt(np.sum(response[:, 0] ** 2)) == pytest.approx(RMS_M, rel=1e-10)


def test_one_step_against_an_integrator():
    a, b = resonance(10.0, 4.0)
    force = TREMOR.b2 / solve_ivp(lambda _, s: a @ s + b, (0, DT), [0, 0], rtol=1e-12, atol=1e-16).y[1, -1]
    state = TremorState(2e-5, -1e-3)
    exact = solve_ivp(lambda _, s: a @ s + 1.3 * force * b, (0, DT), state, rtol=1e-12, atol=1e-18)
    assert tremor_step(state, 1.3, TREMOR) == pytest.approx(tuple(exact.y[:, -1]), rel=1e-9)


def test_speed_is_the_derivative_of_displacement():
    x, v = tremble(*tremor_start(TREMOR, 1), normals(1, 16, 0, 5000), TREMOR).T
    # The drive u is held, so x is smooth within a period, v' = u - 2 pi b v - w^2 x; the trapezium errs by dt^2/12 v''.
    error = (x[1:] - x[:-1]) / DT - (v[1:] + v[:-1]) / 2
    b, omega2 = 2 * math.pi * 4, (2 * math.pi) ** 2 * 108
    u = np.max(np.abs(v[1:] - v[:-1])) / DT + b * np.max(np.abs(v)) + omega2 * np.max(np.abs(x))
    bound = DT**2 / 12 * (2 * b * u + omega2 * np.max(np.abs(v)))
    assert np.max(np.abs(error)) < bound
    assert bound < 1e-3 * np.std(v)


@pytest.mark.parametrize(("peak", "b"), [(10.0, 4.0), (10.0, 0.4), (8.0, 2.0), (12.0, 6.0)])
def test_the_spectrum_peaks_where_asked_and_is_as_wide(peak, b):
    f = np.linspace(1, 30, 290_001)
    power = response(f, peak, b)
    assert f[np.argmax(power)] == pytest.approx(peak, abs=1e-3)
    half = f[power >= power.max() / 2]
    # (f^2 - f_p^2)^2 = b^2 (f_p^2 + b^2/4) where the power is half of its peak; b apart for a narrow peak.
    away = b * math.sqrt(peak**2 + b**2 / 4)
    exact = math.sqrt(peak**2 - away), math.sqrt(peak**2 + away)
    assert (half[0], half[-1]) == pytest.approx(exact, abs=2e-4)
    assert exact[1] - exact[0] == pytest.approx(b, rel=0.5 * (b / peak) ** 2)


def test_spectrum_and_rms_of_what_is_generated():
    seconds = 2000
    x, v = tremble(*tremor_start(TREMOR, 5), normals(5, 16, 0, seconds * 5000), TREMOR).T
    f, power = welch(x, 1 / DT, nperseg=20_000)
    exact = response(f[1:200], 10.0, 4.0)
    exact *= RMS_M**2 / (np.trapezoid(exact, f[1:200]) + exact[0] * f[1])
    # 999 half-overlapping Hann windows: each value has a relative deviation of about 1/sqrt(950) = 0.03; 5 of it.
    inside = (f[1:200] > 1) & (f[1:200] < 25)
    np.testing.assert_allclose(power[1:200][inside] / exact[inside], 1.0, rtol=0, atol=0.17)
    assert 9.0 < f[np.argmax(power)] < 11.0
    # A narrow band decays as e^(-pi b t): pi b T = 25,000 independent values of its variance; 5 deviations.
    assert np.std(x) == pytest.approx(RMS_M, rel=5 * math.sqrt(0.5 / 25_000))
    assert np.std(v) == pytest.approx(2 * math.pi * math.sqrt(108) * RMS_M, rel=5 * math.sqrt(0.5 / 25_000))
    assert np.mean(x) == pytest.approx(0, abs=5 * RMS_M / math.sqrt(20_000))


def test_the_start_is_stationary():
    starts = np.array([tremor_start(TREMOR, seed) for seed in range(4000)])
    c = TREMOR
    exact = covariance(np.array([[c.a11, c.a12], [c.a21, c.a22]]), np.array([c.b1, c.b2]))
    scale = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    # Each entry of a correlation matrix from 4000 draws deviates by at most sqrt(2/4000).
    np.testing.assert_allclose(np.cov(starts.T) / scale, exact / scale, rtol=0, atol=5 * math.sqrt(2 / 4000))
    other = np.array([tremor_start(TREMOR, seed, 1) for seed in range(4000)])
    assert abs(np.corrcoef(starts[:, 0], other[:, 0])[0, 1]) < 5 / math.sqrt(4000)


@given(st.lists(st.floats(-5, 5), min_size=32, max_size=32))
def test_lanes_have_the_bits_of_a_single_step(drive):
    x, rate = np.linspace(-1e-4, 1e-4, 32), np.linspace(2e-3, -3e-3, 32)
    single = [tremor_step((x[i], rate[i]), drive[i], TREMOR) for i in range(32)]
    tremble_lanes(x, rate, np.array(drive), TREMOR)
    assert list(zip(x, rate, strict=True)) == single


def test_no_tremor():
    still = tremor_coefficients(0.0, 10.0, 4.0, DT)
    assert tremor_start(still, 0) == (0.0, 0.0)
    assert tremor_step((0.0, 0.0), 3.0, still) == (0.0, 0.0)
