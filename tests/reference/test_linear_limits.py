"""What no controller can beat: Bode's integral on real loops, the waterbed bound against prediction theory."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

import frictionloop as fl
from frictionloop.analysis import (
    available_crossover_hz,
    bode_integral,
    linearise,
    phase_lag,
    stubborn,
    unstable_sum,
    waterbed_bound,
)

TS, NYQUIST_HZ = 2e-4, 2500.0
LOOPS = {
    "bench": fl.RETUNED,
    "slider": {"controller.kp": 0.01, "controller.ki": 40.0, "finger.slip_length_um": 0.0},
    "late by a fraction": {"controller.kp": 0.02, "controller.ki": 50.0, "controller.delay_s": 1.3e-4},
    "proportional": {"controller.kp": 0.1, "controller.ki": 0.0},
    "nothing": {"controller.kp": 0.0, "controller.ki": 0.0},
    # Its poles make pairs of panel edges that differ by rounding alone.
    "a wide notch and a long delay": {
        "controller.kind": "notch_pi",
        "controller.kp": 6.319873167907791,
        "controller.ki": 58.60039922067161,
        "controller.notch_hz": 152.4805464704759,
        "controller.notch_depth": 0.005257189184609554,
        "controller.notch_width": 10.0,
        "controller.feedforward": True,
        "controller.overdrive": True,
        "controller.delay_s": 3.5e-4,
        "controller.model.resonance_hz": 160.0,
        "controller.model.resonance_q": 15.0,
        "controller.model.plate_hz": 105.6,
        "plate.frequency_hz": 38e3,
        "plate.q": 180.0,
        "plate.max_amplitude_um": 3.0,
        "sensor.resonance_hz": 160.0,
        "sensor.q": 15.0,
        "sensor.moving_mass_kg": 0.3,
        "sensor.adc_bits": 12,
        "sensor.range_n": 2.0,
        "friction.nominal_n": 0.9,
        "friction.susceptibility_per_um2": 0.354,
    },
}


@pytest.mark.parametrize("name", LOOPS)
def test_bode_integral_of_a_stable_loop_is_0(name: str) -> None:
    """Relative degree of at least 1, everything stable: what goes down comes up."""
    loop = linearise(fl.bench().evolve(LOOPS[name]))
    assert unstable_sum(loop) == 0.0
    assert bode_integral(loop) == pytest.approx(0.0, abs=1e-9)


def test_bode_integral_of_an_unstable_loop_is_refused() -> None:
    assert np.isnan(bode_integral(linearise(fl.bench())))


def test_delay_and_zeros_fix_more_of_ln_s() -> None:
    """ln S = s_2 z^-2 + ... of this loop, and ln S = 0 at its plant's zeros outside the unit circle."""
    # Without an integral ln|S| is smooth, and its mean on a grid exact.
    loop = linearise(fl.bench().evolve({"controller.kp": 0.05, "controller.ki": 0.0}))
    found = stubborn(loop)
    assert loop.is_stable() and found.delay_periods == 2
    angle = (np.arange(200_000) + 0.5) * np.pi / 200_000
    S = loop.responses(angle / np.pi * NYQUIST_HZ)["S"]
    level = np.log(np.abs(S))
    first, second = (abs(np.mean(level * np.cos(n * angle))) for n in (1, 2))
    assert first < 1e-12 and second > 1e-8
    for zero in found.zeros:
        turn = np.exp(1j * angle)
        assert np.mean(level * ((zero + turn) / (zero - turn)).real) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("delay_s", [0.0, 2e-4, 6e-4, 1.3e-4])
def test_stubborn_zeros_are_zeros_of_the_response(delay_s: float) -> None:
    """C (z - A)^-1 (new z + old) vanishes there, against the same at +|z|."""
    plant = linearise(fl.bench().evolve({"controller.delay_s": delay_s})).plant
    found = stubborn(linearise(fl.bench().evolve({"controller.delay_s": delay_s})))
    assert found.delay_periods == plant.whole_periods + 1
    assert found.zeros.size >= 1
    for zero in found.zeros:
        there, elsewhere = (
            plant.output[1]
            @ np.linalg.solve(z * np.eye(len(plant.transition)) - plant.transition, plant.new * z + plant.old)
            for z in (zero, -zero)
        )
        assert abs(there) < 1e-6 * abs(elsewhere)


def ar1(phi: float, count: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies and density of d[k+1] = phi d[k] + e, e of 1 N rms."""
    frequency = (np.arange(count) + 0.5) / count * NYQUIST_HZ
    return frequency, 1 / np.abs(1 - phi * np.exp(-1j * np.pi * frequency / NYQUIST_HZ)) ** 2 / NYQUIST_HZ


@settings(deadline=None, max_examples=25)
@given(st.floats(0.0, 0.95), st.integers(1, 8))
def test_without_a_peak_it_is_the_error_of_prediction(phi: float, delay_periods: int) -> None:
    """Of an autoregression the error over d periods is 1 + phi^2 + ... + phi^(2(d-1)) (Wold)."""
    frequency, psd = ar1(phi)
    found = waterbed_bound(frequency, psd, 1e9, NYQUIST_HZ, delay_periods=delay_periods)
    expected = np.sum(phi ** (2.0 * np.arange(delay_periods)))
    assert found.residual_rms_n**2 == pytest.approx(expected, rel=1e-5)


def test_a_zero_costs_what_minimum_variance_says() -> None:
    """White noise cannot be predicted; of a random-walk-like one a zero at -b costs what Blaschke's factor does.

    min |phi-step| with S(z0) = 1 and S(inf) = 1: the error e + Q with Q(inf) = Q(z0) = 0 projects the disturbance's
    impulse response on what the two points see. With F = 1/(1 - phi/z), error power = F at the points through their
    Szego kernel 1/(1 - 1/(z_i z_j)).
    """
    phi, zero = 0.9, -1.8
    frequency, psd = ar1(phi, 20_000)
    found = waterbed_bound(frequency, psd, 1e9, NYQUIST_HZ, zeros=[zero])
    points = np.array([0.0, 1 / zero])  # 1/z of both
    value = 1 / (1 - phi * points)
    kernel = 1 / (1 - np.outer(points, points))
    assert found.residual_rms_n**2 == pytest.approx(value @ np.linalg.solve(kernel, value), rel=1e-4)
    white = waterbed_bound(frequency, np.full_like(psd, 1 / NYQUIST_HZ), 1.5, NYQUIST_HZ, zeros=[zero], delay_periods=3)
    assert white.residual_rms_n == pytest.approx(1.0, rel=1e-9)


def test_the_sensitivity_is_flat_where_it_may_not_rise() -> None:
    """Bode alone: |S|^2 = min(Ms^2, lambda/Phi) with a mean logarithm of 0."""
    frequency, psd = ar1(0.95)
    found = waterbed_bound(frequency, psd, 1.3, NYQUIST_HZ)
    S = found.sensitivity
    assert np.mean(np.log(S)) == pytest.approx(0.0, abs=1e-9)
    free = S < 1.3 * (1 - 1e-9)
    assert 0.2 < free.mean() < 0.8
    np.testing.assert_allclose((S**2 * psd)[free], (S**2 * psd)[free][0], rtol=1e-9)
    assert np.all((S**2 * psd)[~free] < (S**2 * psd)[free][0])
    assert frequency[S >= 1].min() == found.zero_db_hz


@pytest.mark.parametrize("options", [{}, {"delay_periods": 3}, {"delay_periods": 2, "zeros": [-1.4]}])
def test_it_is_the_minimum(options: dict[str, object]) -> None:
    """Against a general optimiser on a coarse grid."""
    frequency, psd = ar1(0.9, 24)
    angle = (np.arange(25)) * np.pi / 24
    rows = [np.diff(angle)]
    rows += [np.diff(np.sin(n * angle)) / n for n in range(1, options.get("delay_periods", 1))]
    for zero in options.get("zeros", []):
        fine = (np.arange(24 * 200) + 0.5) * np.pi / (24 * 200)
        kernel = ((zero + np.exp(1j * fine)) / (zero - np.exp(1j * fine))).real
        rows.append(kernel.reshape(24, 200).mean(axis=1) * np.pi / 24)
    found = waterbed_bound(frequency, psd, 1.4, NYQUIST_HZ, **options)
    best = minimize(
        lambda level: np.sum(psd * np.exp(2 * level)) * 1e2,
        np.zeros(24),
        jac=lambda level: 2e2 * psd * np.exp(2 * level),
        bounds=[(-8, np.log(1.4))] * 24,
        constraints={"type": "eq", "fun": lambda level: np.array(rows) @ level, "jac": lambda level: np.array(rows)},
        method="SLSQP",
        options={"maxiter": 500, "ftol": 1e-14},
    )
    assert best.success
    power = np.sum(psd * np.exp(2 * best.x)) * NYQUIST_HZ / 24
    assert found.residual_rms_n**2 == pytest.approx(power, rel=1e-5)


@pytest.mark.parametrize("name", ["bench", "slider", "late by a fraction", "proportional"])
@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
def test_no_loop_beats_it(name: str, exponent: float) -> None:
    loop = linearise(fl.bench().evolve(LOOPS[name]))
    frequency = np.geomspace(0.05, NYQUIST_HZ, 4000)
    psd = 1e-4 / (1.0 + frequency**exponent)
    S, peak = np.abs(loop.responses(frequency)["S"]), loop.margins().sensitivity_peak
    edges = np.concatenate([[0.0], (frequency[1:] + frequency[:-1]) / 2, [NYQUIST_HZ]])
    left = np.sqrt(np.diff(edges) @ (S**2 * psd))
    found = stubborn(loop)
    bode = waterbed_bound(frequency, psd, peak, NYQUIST_HZ)
    all_of_it = waterbed_bound(frequency, psd, peak, NYQUIST_HZ, delay_periods=found.delay_periods, zeros=found.zeros)
    assert bode.residual_rms_n < all_of_it.residual_rms_n < left
    assert np.max(all_of_it.sensitivity) <= peak * (1 + 1e-12)


def test_phase_lag() -> None:
    """Against the responses of the elements, continuous, where no turn is lost."""
    loop = linearise(fl.bench().evolve({"controller.delay_s": 2e-4}))
    for frequency_hz in (10.0, 100.0, 145.0, 300.0):
        lag, f = phase_lag(loop, frequency_hz), np.array([frequency_hz])
        series = loop.elements.plate.response(f) * loop.elements.sensor.response(f)
        series = series * np.exp(-2j * np.pi * f * (2e-4 + TS / 2))
        assert np.exp(-1j * np.radians(lag.total)) == pytest.approx((series / abs(series))[0], abs=1e-9)
    assert phase_lag(loop, 145.0).springs == pytest.approx(90.0)
    assert phase_lag(loop, 100.0).fixed == pytest.approx(360 * 100 * 3e-4)


def test_available_crossover() -> None:
    """Delay alone: 45 degrees of 360 f 300 us at 417 Hz; what is not inverted takes most of it."""
    loop = linearise(fl.bench())
    assert available_crossover_hz(loop) == pytest.approx(45 / 360 / 3e-4)
    as_it_is = available_crossover_hz(loop, inverted=False)
    assert phase_lag(loop, as_it_is).total == pytest.approx(45.0)
    assert as_it_is < 100
    assert available_crossover_hz(linearise(fl.paper())) == pytest.approx(NYQUIST_HZ / 2)
