"""The linear optimum: prediction theory, LQG by Riccati equations, a search over FIR filters, laws that exist."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are, solve_discrete_lyapunov
from scipy.optimize import minimize

from frictionloop.analysis import waterbed_bound
from studies.linear_optimum import linear_optimum

TS, NYQUIST_HZ = 2e-4, 2500.0
FREQUENCY_HZ = (np.arange(5000) + 0.5) * NYQUIST_HZ / 5000
BACK = np.exp(-2j * np.pi * FREQUENCY_HZ * TS)
NONE = np.zeros_like(FREQUENCY_HZ)


def first_order(pole: float, sigma: float = 1.0) -> np.ndarray:
    """One-sided density of d[k+1] = pole d[k] + e, e of standard deviation sigma."""
    return 2.0 * TS * (sigma / np.abs(1.0 - pole * BACK)) ** 2


def optimum(psd, noise, peak, reading, friction=(1.0,), **options):
    return linear_optimum(FREQUENCY_HZ, psd, noise, peak, NYQUIST_HZ, reading=reading, friction=friction, **options)


@pytest.mark.parametrize("pole", [0.5, 0.9, 0.97])
@pytest.mark.parametrize("periods", [1, 2, 5])
def test_a_pure_delay_leaves_the_error_of_the_best_prediction(pole: float, periods: int) -> None:
    found = optimum(first_order(pole), NONE, np.inf, [0.0] * periods + [1.0])
    least = np.sqrt(np.sum(pole ** (2 * np.arange(periods))))
    assert found.residual_rms_n == pytest.approx(least, rel=1e-3)
    assert found.bound_rms_n == pytest.approx(least, rel=1e-3)
    assert found.noise_rms_n == 0.0


def test_a_zero_outside_the_circle_leaves_what_it_hides() -> None:
    """Around B = z^-1 (1 + b z^-1)/(1 + b), b > 1: white noise e of 1, X free: all of e[k]; with a pole more of it.

    The inner factor z^-1 (z^-1 + 1/b)/(1 + z^-1/b) hides from H = 1/(1 - a z^-1) the part of H over it that is not
    causal: 1/(1 - a z^-1) (1 + z^-1/b)/(z^-1 (z^-1 + 1/b)) has the anticausal part z + c/(1 + z/b), by residues.
    """
    a, b = 0.8, 2.0
    found = optimum(first_order(a), NONE, np.inf, [0.0, 1.0, b])
    # Partial fractions in w = z^-1: H (1 + w/b)/(w (w + 1/b)) = b/w + r/(w + 1/b) + causal; r at w = -1/b, expanded
    # anticausally: r/(w + 1/b) = r z/(1 + z/b).
    r = (1.0 / (1.0 + a / b)) * (1.0 - 1.0 / b**2) * (-b)
    anticausal = [b + r] + [r * (-1.0 / b) ** k for k in range(1, 200)]
    assert found.bound_rms_n == pytest.approx(np.sqrt(np.sum(np.square(anticausal))), rel=1e-3)


def test_without_delay_and_noise_nothing_is_left() -> None:
    found = optimum(first_order(0.9), NONE, 1.7, [1.0, 0.3])
    assert found.residual_rms_n < 1e-6


def lqg_rms(pole: float, lag: float, command: np.ndarray, noise: float, price: float = 1e-10) -> tuple[float, float]:
    """Rms of f = d + (command taps) u and of u under LQG on y = lag filter of f, plus white noise: two DAREs."""
    taps = command.size - 1  # command[0] = 0: what is commanded now comes later
    n = taps + 2
    A, B = np.zeros((n, n)), np.zeros((n, 1))
    A[1:taps, : taps - 1], B[0] = np.eye(taps - 1), 1.0
    f = np.zeros((1, n))
    f[0, :taps], f[0, taps] = command[1:], 1.0  # u[k-1], u[k-2], ..., d
    A[taps, taps] = pole
    A[taps + 1] = lag * np.eye(n)[taps + 1] + (1.0 - lag) * f[0]  # s[k+1] = lag s[k] + (1 - lag) f[k]
    y = lag * np.eye(n)[[taps + 1]] + (1.0 - lag) * f
    drive = np.zeros((n, n))
    drive[taps, taps] = 1.0
    P = solve_discrete_are(A.T, y.T, drive, [[noise**2]])
    gain = P @ y.T / (y @ P @ y.T + noise**2)
    K = solve_discrete_are(A, B, f.T @ f, [[price]])
    law = np.linalg.solve(B.T @ K @ B + price, B.T @ K @ A)
    # x and its prediction xp: u = -law (xp + gain (y x + v - y xp)).
    kept = np.eye(n) - gain @ y
    loop = np.block([[A - B @ law @ gain @ y, -B @ law @ kept], [(A - B @ law) @ gain @ y, (A - B @ law) @ kept]])
    heard = np.vstack([-B @ law @ gain, (A - B @ law) @ gain])
    driven = np.zeros((2 * n, 2 * n))
    driven[:n, :n] = drive
    spread = solve_discrete_lyapunov(loop, driven + noise**2 * heard @ heard.T)
    assert np.abs(np.linalg.eigvals(loop)).max() < 1.0
    # u = -law (kept xp + gain (y x + v)).
    told, said = np.hstack([law @ gain @ y, law @ kept]), float((law @ gain).item())
    command_square = (told @ spread @ told.T).item() + (noise * said) ** 2
    return float(np.sqrt((f @ spread[:n, :n] @ f.T).item())), float(np.sqrt(command_square))


@pytest.mark.parametrize("command", [[0, 1.0], [0, 0, 1.0], [0, 0, 0.4, 0.6], [0, 0, 0, 0.2, 1.0, -0.3]])
@pytest.mark.parametrize(("pole", "lag", "noise"), [(0.9, 0.3, 0.5), (0.98, 0.7, 2.0), (0.98, 0.0, 0.1)])
def test_with_noise_it_is_lqg(command: list[float], pole: float, lag: float, noise: float) -> None:
    """Reading over 1 - lag z^-1: what friction's numerator has, the reading's has times (1 - lag)."""
    taps = np.array(command, dtype=float)
    white = np.full_like(FREQUENCY_HZ, 2.0 * TS * noise**2)
    found = optimum(first_order(pole), white, np.inf, (1.0 - lag) * taps, np.convolve(taps, [1.0, -lag]))
    assert found.residual_rms_n == pytest.approx(lqg_rms(pole, lag, taps, noise)[0], rel=2e-3)


@pytest.mark.parametrize("command", [[0, 1.0], [0, 0, 0.4, 0.6], [0, 0, 0, 0.2, 1.0, -0.3]])
@pytest.mark.parametrize(("pole", "lag", "noise"), [(0.9, 0.3, 0.5), (0.98, 0.7, 2.0), (0.98, 0.0, 0.1)])
@pytest.mark.parametrize("price", [0.03, 0.3, 3.0])
def test_with_a_command_kept_small_it_is_lqg_that_pays_for_it(command, pole, lag, noise, price) -> None:
    taps, white = np.array(command, dtype=float), np.full_like(FREQUENCY_HZ, 2.0 * TS * noise**2)
    left, driven = lqg_rms(pole, lag, taps, noise, price)
    paths = {"reading": (1.0 - lag) * taps, "friction": np.convolve(taps, [1.0, -lag]), "poles": [1.0, -lag]}
    found = optimum(first_order(pole), white, np.inf, largest_drive_n=driven, **paths)
    assert 0.9 * driven < found.drive_rms_n <= driven
    # The price is found to a tenth, so the command is a little smaller than it may be; the bounds hold what that is.
    assert (1.0 - 2e-3) * found.bound_rms_n <= left <= (1.0 + 2e-3) * found.residual_rms_n
    assert found.residual_rms_n < 1.02 * found.bound_rms_n


@pytest.mark.parametrize(("peak", "noise"), [(1.3, 0.0), (1.7, 0.4), (2.0, 0.2)])
def test_with_a_peak_a_search_over_fir_filters_comes_to_it_as_they_grow(peak: float, noise: float) -> None:
    hertz = (np.arange(250) + 0.5) * NYQUIST_HZ / 250
    back = np.exp(-2j * np.pi * hertz * TS)
    psd = 2.0 * TS / np.abs(1.0 - 0.9 * back) ** 2
    white, reading = np.full_like(hertz, 2.0 * TS * noise**2), np.array([0.0, 0.0, 0.7, 0.5])
    found = linear_optimum(hertz, psd, white, peak, NYQUIST_HZ, reading=reading, friction=reading)
    path = np.polynomial.polynomial.polyval(back, reading)[:, None]
    theirs = [searched_rms(path * back[:, None] ** np.arange(taps), psd, white, peak) for taps in (3, 7, 28)]
    assert theirs[0] > theirs[1] > theirs[2]
    # Between our bounds, 0.2 % apart, but for its finite length and for keeping the peak at 250 frequencies alone.
    assert 0.999 * found.bound_rms_n < theirs[2] < 1.001 * found.residual_rms_n
    assert found.residual_rms_n < 1.0021 * found.bound_rms_n


def searched_rms(basis: np.ndarray, psd: np.ndarray, white: np.ndarray, peak: float) -> float:
    """Least rms over X = sum of taps times a basis behind N_y = N_f, by sequential quadratic programmes."""
    width_hz = NYQUIST_HZ / psd.size

    def power(q: np.ndarray) -> tuple[float, np.ndarray]:
        S, heard = 1.0 - basis @ q, basis @ q
        slope = 2.0 * (basis.conj().T @ (white * heard - psd * S)).real
        return width_hz * float(psd @ np.abs(S) ** 2 + white @ np.abs(heard) ** 2), width_hz * slope

    room = {
        "type": "ineq",
        "fun": lambda q: peak**2 - np.abs(1.0 - basis @ q) ** 2,
        "jac": lambda q: 2.0 * (np.conj(1.0 - basis @ q)[:, None] * basis).real,
    }
    start, options = np.zeros(basis.shape[1]), {"maxiter": 400}
    searched = minimize(power, start, jac=True, constraints=room, method="SLSQP", options=options)
    assert searched.success
    return float(np.sqrt(searched.fun))


@settings(max_examples=25, deadline=None)
@given(
    st.floats(0.3, 0.99),
    st.integers(1, 4),
    st.floats(0.0, 3.0),
    st.floats(0.0, 2.0),
    st.floats(1.2, 2.5),
)
def test_it_lies_between_the_waterbed_and_no_control(pole, periods, zero, noise, peak) -> None:
    # Without noise a zero on the unit circle asks for infinite gain at one frequency, which no grid of bins holds.
    assume(noise > 0.0 or abs(zero - 1.0) > 0.01)
    psd, white = first_order(pole), np.full_like(FREQUENCY_HZ, 2.0 * TS * noise**2)
    reading = [0.0] * periods + [1.0, zero]
    found = [optimum(psd, white, each, reading, bins_to_nyquist=4096) for each in (peak, 1.3 * peak, np.inf)]
    bound = [each.bound_rms_n for each in found]
    assert all(
        low <= high * (1 + 1e-9) for low, high in zip(bound, [each.residual_rms_n for each in found], strict=True)
    )
    assert found[0].residual_rms_n <= 1.0021 * bound[0]
    assert found[0].sensitivity_peak <= peak * (1 + 1e-9)
    assert bound[1] <= found[0].residual_rms_n and bound[2] <= found[1].residual_rms_n
    without = np.sqrt(psd.sum() * NYQUIST_HZ / psd.size)
    assert found[0].residual_rms_n <= without * (1 + 1e-9)
    outside = (-zero,) if zero > 1.01 else ()
    least = waterbed_bound(FREQUENCY_HZ, psd, peak, NYQUIST_HZ, delay_periods=periods, zeros=outside)
    assert found[0].residual_rms_n >= least.residual_rms_n * 0.998


def test_it_does_not_depend_on_the_number_of_bins() -> None:
    white = np.full_like(FREQUENCY_HZ, 2.0 * TS * 0.3**2)
    found = [
        optimum(first_order(0.98), white, 1.7, [0, 0, 0.5, 0.7], bins_to_nyquist=2**k).bound_rms_n
        for k in range(11, 16)
    ]
    assert np.ptp(found) < 3e-3 * found[-1]
