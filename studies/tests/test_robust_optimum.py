"""The bound that bears other plants: the linear optimum, a search over FIR filters, laws that exist, and its errors."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

import frictionloop as fl
from studies.linear_optimum import linear_optimum
from studies.linear_reach import linear_reach
from studies.robust_optimum import RobustOptimum, _turns, robust_optimum
from studies.robust_reach import robust_reach
from studies.wiener_hopf import Spectra, bins

TS, NYQUIST_HZ, BINS = 2e-4, 2500.0, 2**11
FREQUENCY_HZ = (np.arange(5000) + 0.5) * NYQUIST_HZ / 5000


def density(pole: float, hertz: np.ndarray = FREQUENCY_HZ) -> np.ndarray:
    """One-sided density of d[k+1] = pole d[k] + e, e of standard deviation 1."""
    return 2.0 * TS / np.abs(1.0 - pole * np.exp(-2j * np.pi * hertz * TS)) ** 2


def spectra_of(pole: float, noise: float, reading: list[float], size: int = BINS) -> Spectra:
    white = np.full_like(FREQUENCY_HZ, 2.0 * TS * noise**2)
    return bins(FREQUENCY_HZ, density(pole), white, NYQUIST_HZ, (reading, reading, (1.0,)), size)


def of_gains(spectra: Spectra, gains: list[float], peaks: list[float], **options: float) -> RobustOptimum:
    ratios = np.array(gains)[:, None] * np.ones(spectra.width_hz.size, dtype=complex)
    return robust_optimum(spectra, ratios, np.array(peaks), **options)


@pytest.mark.parametrize(("peak", "noise"), [(1.3, 0.0), (1.7, 0.4), (2.0, 0.2), (1.5, 2.0)])
@pytest.mark.parametrize("reading", [[0, 0, 0.7, 0.5], [0, 1.0, 1.6]])
def test_of_the_own_plant_alone_it_is_the_linear_optimum(peak: float, noise: float, reading: list[float]) -> None:
    white = np.full_like(FREQUENCY_HZ, 2.0 * TS * noise**2)
    asked = FREQUENCY_HZ, density(0.97), white, peak, NYQUIST_HZ
    lawson = linear_optimum(*asked, reading=reading, friction=reading, bins_to_nyquist=BINS)
    found = of_gains(spectra_of(0.97, noise, reading), [1.0], [peak])
    assert found.bound_rms_n < 1.001 * lawson.residual_rms_n
    assert found.bound_rms_n > 0.998 * lawson.bound_rms_n
    assert found.stable and found.excess < 1.003


def test_of_other_gains_a_search_over_fir_filters_comes_to_it_as_they_grow() -> None:
    """Gains 0.7 to 1.4 times the own: all discs, so a convex problem, and one that a quadratic programme solves."""
    gains, peaks, reading = np.array([1.0, 1.4, 0.7]), np.array([1.7, 1.8, 1.6]), np.array([0.0, 0.0, 0.7, 0.5])
    hertz = (np.arange(200) + 0.5) * NYQUIST_HZ / 200
    back = np.exp(-2j * np.pi * hertz * TS)
    psd, white = density(0.97, hertz), np.full_like(hertz, 2.0 * TS * 0.3**2)
    theirs = []
    for taps in (3, 8, 24):
        basis = np.polynomial.polynomial.polyval(back, reading)[:, None] * back[:, None] ** np.arange(taps)

        def left(q: np.ndarray, basis: np.ndarray = basis) -> tuple[float, np.ndarray]:
            S, heard = 1.0 - basis @ q, basis @ q
            slope = 2.0 * (basis.conj().T @ (white * heard - psd * S)).real
            return float(psd @ np.abs(S) ** 2 + white @ np.abs(heard) ** 2), slope

        def room(q: np.ndarray, basis: np.ndarray = basis) -> np.ndarray:
            S = 1.0 - basis @ q
            return np.ravel(
                [(m * np.abs(r + (1 - r) * S)) ** 2 - np.abs(S) ** 2 for r, m in zip(gains, peaks, strict=True)]
            )

        def turned(q: np.ndarray, basis: np.ndarray = basis) -> np.ndarray:
            S = 1.0 - basis @ q
            rows = [m**2 * (1 - r) * np.conj(r + (1 - r) * S) - np.conj(S) for r, m in zip(gains, peaks, strict=True)]
            return -2.0 * np.vstack([(row[:, None] * basis).real for row in rows])

        room_for = {"type": "ineq", "fun": room, "jac": turned}
        options = {"maxiter": 400}
        found = minimize(left, np.zeros(taps), jac=True, constraints=room_for, method="SLSQP", options=options)
        assert found.success
        theirs.append(np.sqrt(found.fun * NYQUIST_HZ / hertz.size))
    ours = of_gains(spectra_of(0.97, 0.3, reading.tolist()), gains.tolist(), peaks.tolist())
    assert theirs[0] > theirs[1] > theirs[2]
    assert 0.998 * ours.bound_rms_n < theirs[2] < 1.005 * ours.residual_rms_n
    assert ours.residual_rms_n < 1.003 * ours.bound_rms_n
    alone = of_gains(spectra_of(0.97, 0.3, reading.tolist()), [1.0], [1.7])
    assert ours.bound_rms_n > 1.02 * alone.residual_rms_n  # the other gains do cost something here


@settings(max_examples=15, deadline=None)
@given(st.floats(0.5, 0.99), st.floats(0.1, 2.0), st.floats(0.5, 2.0), st.floats(1.2, 2.5))
def test_it_is_below_every_integral_controller_that_keeps_its_own_peaks(pole, noise, gain, share) -> None:
    """u[k] = u[k-1] - g y[k] around z^-2: S = (z - 1) z/((z - 1) z + g), stable for g below 1; its peaks are asked."""
    spectra = spectra_of(pole, noise, [0.0, 0.0, 1.0], 1024)
    z = np.exp(1j * np.pi * np.arange(1025) / 1024)
    g = 0.35 * share / 2.5
    S = [(z - 1) * z / ((z - 1) * z + g * each) for each in (1.0, gain)]
    peaks = [max(1.001 * float(np.abs(each).max()), 1.01) for each in S]
    left = np.abs(S[0]) ** 2 * spectra.disturbance + np.abs(1.0 - S[0]) ** 2 * spectra.noise
    found = of_gains(spectra, [1.0, gain], peaks)
    assert found.bound_rms_n <= np.sqrt(spectra.width_hz @ left) * (1 + 1e-6)


@pytest.mark.slow
def test_fingers_are_bound_by_more_than_by_the_own_resonance() -> None:
    bench = fl.bench().evolve({"motion.stroke_mm": 240.0})
    people = [{}, {"sensor.resonance_hz": 145.0 * 1.05}, {"friction.nominal_n": 0.3}]
    asked = {"seed": 7, "levels_n": [0.6]}
    bound = robust_reach(bench, people, **asked)["bound_rms_n"]
    own = linear_reach(bench, people, peaks=[1.7], **asked).sel(measured="force and load")["driven_rms_n"].squeeze()
    assert bound.values[0] == pytest.approx(own.values[0], rel=0.03)
    assert bound.values[1] > 0.9 * own.values[1]
    assert np.isnan(bound.values[2])
    with_other_levels = robust_reach(bench, people[:1], limits={0.0: 1.7, 0.1: 1.75}, **asked)["bound_rms_n"]
    assert with_other_levels.values[0] > bound.values[0]


@pytest.mark.parametrize("drive_n", [0.3, 0.6])
def test_with_a_command_kept_small_it_is_the_linear_optimum_that_spares_it(drive_n: float) -> None:
    reading, poles, white = [0.0, 0.0, 0.3], [1.0, -0.7], np.full_like(FREQUENCY_HZ, 2.0 * TS * 0.4**2)
    spectra = bins(FREQUENCY_HZ, density(0.97), white, NYQUIST_HZ, (reading, reading, poles), BINS)
    asked = {"reading": reading, "friction": reading, "poles": poles, "bins_to_nyquist": BINS}
    free = linear_optimum(FREQUENCY_HZ, density(0.97), white, 1.7, NYQUIST_HZ, **asked)
    most_n = drive_n * free.drive_rms_n
    spared = linear_optimum(FREQUENCY_HZ, density(0.97), white, 1.7, NYQUIST_HZ, largest_drive_n=most_n, **asked)
    found = of_gains(spectra, [1.0], [1.7], largest_drive_n=most_n)
    assert 0.98 * spared.bound_rms_n < found.bound_rms_n < 1.001 * spared.residual_rms_n
    assert found.bound_rms_n > 1.005 * free.residual_rms_n  # sparing costs something here
    assert 0.5 * most_n < found.drive_rms_n < 1.5 * most_n


def test_an_unstable_answer_on_another_plant_is_told() -> None:
    """z^-1 under an integrator of gain g: S = (z - 1)/(z - 1 + g), unstable where gain times g is above 2."""
    z, g = np.exp(1j * np.pi * np.arange(1025) / 1024), 0.8
    S = (z - 1.0) / (z - 1.0 + g)
    turns = [_turns(gain + (1.0 - gain) * S) for gain in (0.5, 1.0, 2.4, 2.6, 3.0)]
    assert turns == [0, 0, 0, -1, -1]
