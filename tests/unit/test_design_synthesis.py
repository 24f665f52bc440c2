"""The two syntheses: norms on a dense grid, closed-loop poles, H2 optimality, and against SciPy's Riccati solvers."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import LinAlgError, null_space, solve_continuous_are, solve_discrete_are, solve_discrete_lyapunov

from frictionloop.design.quadruple import Quadruple, balanced, bilinear, realised, series
from frictionloop.design.slicot import Generalised, lqg, synthesise
from frictionloop.quantities import FrictionloopError, Lti

CIRCLE = np.exp(1j * np.append(np.geomspace(1e-4, np.pi, 3000), 0.0))
seeds = st.integers(0, 2**32 - 1)


def plant(seed: int, n: int = 5, m: int = 3, p: int = 3, radius: float = 1.1, d22: float = 0.3) -> Generalised:
    """A random plant, unstable by itself."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n))
    A *= radius / np.abs(np.linalg.eigvals(A)).max()
    D = rng.normal(size=(p + 1, m + 1))
    D[:p, m] += np.sign(D[:p, m])
    D[p, :m] += np.sign(D[p, :m])
    D[p, m] = d22
    return Generalised(Quadruple(A, rng.normal(size=(n, m + 1)), rng.normal(size=(p + 1, n)), D))


def closed(P: Generalised, K: Quadruple) -> Quadruple:
    """z from w with u = K y, by solving for u and y at every instant: no formula of the synthesis in it."""
    A, B, C, D = P.system
    n, k, m, p = len(A), len(K.A), B.shape[1] - 1, C.shape[0] - 1
    # u = Ck xk + Dk y, y = C2 x + D21 w + D22 u.
    inner = np.array([[1.0, -K.D[0, 0]], [-D[p, m], 1.0]])
    rhs = np.block([[np.zeros((1, n)), K.C, np.zeros((1, m))], [C[p:], np.zeros((1, k)), D[p:, :m]]])
    u, y = np.linalg.solve(inner, rhs)
    left = np.block(
        [
            [A, np.zeros((n, k)), B[:, :m]],
            [np.zeros((k, n)), K.A, np.zeros((k, m))],
            [C[:p], np.zeros((p, k)), D[:p, :m]],
        ]
    )
    left[:n] += B[:, m:] * u
    left[n : n + k] += K.B * y
    left[n + k :] += D[:p, m:] * u
    N = n + k
    return Quadruple(left[:N, :N], left[:N, N:], left[N:, :N], left[N:, N:])


def norm(system: Quadruple) -> float:
    return float(np.linalg.norm(system.at(CIRCLE), 2, axis=(1, 2)).max())


def h2(system: Quadruple) -> float:
    return float(np.trace(system.C @ solve_discrete_lyapunov(system.A, system.B @ system.B.T) @ system.C.T)) + float(
        np.sum(system.D**2)
    )


@settings(max_examples=15)
@given(seed=seeds)
def test_hinf_keeps_its_norm_and_is_stable(seed: int) -> None:
    P = plant(seed)
    found = synthesise(P)
    loop = closed(P, found.controller)
    assert np.abs(np.linalg.eigvals(loop.A)).max() < 1
    assert norm(loop) <= found.gamma * (1 + 1e-6)


@settings(max_examples=10)
@given(seed=seeds)
def test_hinf_is_below_lqg_in_its_norm_and_above_in_the_other(seed: int) -> None:
    P = plant(seed, d22=0.0)
    worst, mean = closed(P, synthesise(P).controller), closed(P, lqg(P))
    assert np.abs(np.linalg.eigvals(mean.A)).max() < 1
    assert norm(worst) <= 1.011 * norm(mean)
    assert h2(mean) <= h2(worst) * (1 + 1e-9)


@settings(max_examples=10)
@given(seed=seeds)
def test_no_small_change_of_the_lqg_controller_lowers_the_variance(seed: int) -> None:
    P, rng = plant(seed, n=3, d22=0.0), np.random.default_rng(seed)
    K = lqg(P)
    least = h2(closed(P, K))
    for part in range(4):
        for sign in (-1, 1):
            step = [np.zeros_like(x) for x in K]
            step[part] = sign * 1e-4 * rng.normal(size=K[part].shape)
            other = closed(P, Quadruple(*(x + dx for x, dx in zip(K, step, strict=True))))
            assert h2(other) >= least * (1 - 1e-9)


def stabilising(A, B, S, R, Q):
    """X >= 0 of A'X + XA + Q - (XB + S) R^-1 (XB + S)' = 0 with A - B R^-1 (XB + S)' stable, None without."""
    try:
        X = solve_continuous_are(A, B, Q, R, s=S)
    except (LinAlgError, ValueError):
        return None
    gain = np.linalg.solve(R, (X @ B + S).T)
    left = np.abs(A.T @ X + X @ A + Q - (X @ B + S) @ gain).max() / np.abs(X).max()
    stable = np.linalg.eigvals(A - B @ gain).real.max() < 0
    return X if stable and left < 1e-6 and np.linalg.eigvalsh(X).min() > -1e-7 * np.abs(X).max() else None


def some_controller_keeps(P: Generalised, gamma: float) -> bool:
    """Zhou, Doyle, Glover, Robust and Optimal Control, theorem 17.1, with D12 and D21 as they are."""
    A, B, C, D = bilinear(P.system)
    B1, C1, D11, D12, D21 = B[:, :-1], C[:-1], D[:-1, :-1], D[:-1, -1:], D[-1:, :-1]
    if gamma <= max(np.linalg.norm(null_space(D12.T).T @ D11, 2), np.linalg.norm(D11 @ null_space(D21), 2)):
        return False
    row, column = D[:-1], D[:, :-1]
    R = row.T @ row - gamma**2 * np.diag([1.0] * B1.shape[1] + [0.0])
    S = column @ column.T - gamma**2 * np.diag([1.0] * len(C1) + [0.0])
    X = stabilising(A, B, C1.T @ row, R, C1.T @ C1)
    Y = stabilising(A.T, C.T, B1 @ column.T, S, B1 @ B1.T)
    return X is not None and Y is not None and np.abs(np.linalg.eigvals(X @ Y)).max() < gamma**2


@pytest.mark.parametrize("seed", range(8))
def test_hinf_gets_to_the_least_norm_that_two_riccati_equations_allow(seed: int) -> None:
    P = plant(seed)
    found = synthesise(P)
    assert some_controller_keeps(P, found.gamma)
    assert not some_controller_keeps(P, found.gamma / 1.01)


@pytest.mark.parametrize("seed", range(8))
def test_lqg_against_two_riccati_equations(seed: int) -> None:
    P = plant(seed, d22=0.0)
    A, B, C, D = P.system
    B1, B2, C1, C2, D11, D12, D21 = B[:, :-1], B[:, -1:], C[:-1], C[-1:], D[:-1, :-1], D[:-1, -1:], D[-1:, :-1]
    X = solve_discrete_are(A, B2, C1.T @ C1, D12.T @ D12, s=C1.T @ D12)
    Y = solve_discrete_are(A.T, C2.T, B1 @ B1.T, D21 @ D21.T, s=B1 @ D21.T)
    inner, spread = D12.T @ D12 + B2.T @ X @ B2, np.linalg.inv(C2 @ Y @ C2.T + D21 @ D21.T)
    F = np.linalg.solve(inner, B2.T @ X @ A + D12.T @ C1)
    L = (A @ Y @ C2.T + B1 @ D21.T) @ spread
    # w that is seen in y acts in this period too: its estimate is D21' spread (y - C2 x).
    seen = np.linalg.solve(inner, (B2.T @ X @ B1 + D12.T @ D11) @ D21.T) @ spread
    direct = -(F @ Y @ C2.T @ spread + seen)
    state = -F - direct @ C2
    wanted = Quadruple(A + B2 @ state - L @ C2, L + B2 @ direct, state, direct)
    assert lqg(P).at(CIRCLE) == pytest.approx(wanted.at(CIRCLE), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("method", [synthesise, lqg])
def test_without_slicot_the_extra_is_named(monkeypatch, method) -> None:
    monkeypatch.setitem(sys.modules, "ctrlsys", None)
    with pytest.raises(FrictionloopError, match=r"^ctrlsys is missing; install with: .*'\.\[design\]'$"):
        method(plant(1, d22=0.0))


def test_hinf_against_python_control() -> None:
    control = pytest.importorskip("control", reason="python-control is not installed")
    pytest.importorskip("slycot", reason="python-control's hinfsyn needs slycot, which is under the GPL")
    P = plant(3)
    _, _, gamma, _ = control.hinfsyn(control.ss(*bilinear(P.system)), 1, 1)
    assert synthesise(P).gamma == pytest.approx(gamma, rel=0.02)


def test_needs_weight_and_noise() -> None:
    P = plant(1)
    D = P.system.D.copy()
    D[:-1, -1] = 0.0
    moved = Generalised(bilinear(bilinear(P.system)._replace(D=D), back=True))
    with pytest.raises(FrictionloopError, match="a weight on every command and a noise in every reading"):
        synthesise(moved)
    with pytest.raises(FrictionloopError, match="must not reach the measurement"):
        lqg(P)


def test_an_uncontrollable_plant_does_not_converge() -> None:
    A, C = np.diag([1.5, 0.5]), np.array([[1.0, 1.0], [1.0, 1.0]])
    P = Generalised(Quadruple(A, np.array([[1.0, 0.0], [1.0, 1.0]]), C, np.array([[0.0, 1.0], [1.0, 0.0]])))
    for synthesis in (synthesise, lqg):
        with pytest.raises(FrictionloopError, match="does not converge") as caught:
            synthesis(P)
        assert "\n" not in str(caught.value)


@settings(max_examples=30)
@given(seed=seeds)
def test_bilinear_keeps_the_response_and_returns(seed: int) -> None:
    system = plant(seed, radius=0.8).system
    z = CIRCLE[:2000:50]
    moved = bilinear(system)
    assert moved.at((z - 1) / (z + 1)) == pytest.approx(system.at(z), rel=1e-6, abs=1e-8)
    for back, was in zip(bilinear(moved, back=True), system, strict=True):
        assert back == pytest.approx(was, rel=1e-6, abs=1e-8)


@settings(max_examples=30)
@given(seed=seeds, order=st.integers(1, 5))
def test_truncation_keeps_its_bound(seed: int, order: int) -> None:
    moved = bilinear(plant(seed, n=6, radius=0.9).system)
    small, sizes = balanced(moved, order)
    s = 1j * np.geomspace(1e-4, 1e4, 400)
    error = np.linalg.norm(moved.at(s) - small.at(s), 2, axis=(1, 2)).max()
    assert len(small.A) == order
    assert np.linalg.eigvals(small.A).real.max() < 0
    assert error <= 2 * sizes[order:].sum() * (1 + 1e-6) + 1e-9 * sizes[0]


def test_series_is_a_product() -> None:
    one, two = (Quadruple(*(x[:1] if i in (2, 3) else x for i, x in enumerate(plant(k).system))) for k in (1, 2))
    one = one._replace(B=one.B[:, :1], D=one.D[:, :1])
    two = two._replace(B=two.B[:, :1], D=two.D[:, :1])
    z = CIRCLE[::100]
    assert series([one, two]).at(z) == pytest.approx(two.at(z) @ one.at(z), rel=1e-9)


@pytest.mark.parametrize("den", [[1.0, 2.0], [1.0, 2.0, 50.0], [1.0, 500.0, 6e4, 1e5, 20.0]])
def test_realised_is_tustins_rule(den: list[float]) -> None:
    filter_, f, period_s = Lti((3.0, 7.0), tuple(den)), np.geomspace(0.01, 2000, 60), 2e-4
    s = 2 / period_s * 1j * np.tan(np.pi * f * period_s)
    wanted = np.polyval(filter_.num, s) / np.polyval(filter_.den, s)
    found = realised(filter_, period_s).at(np.exp(2j * np.pi * f * period_s))[:, 0, 0]
    assert found == pytest.approx(wanted, rel=1e-8)
