"""The synthesis: norms on a dense grid, closed-loop poles, and against SciPy's Riccati solvers."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import LinAlgError, null_space, solve_continuous_are

from frictionloop.design.slicot import Quadruple, balanced, bilinear, synthesise
from frictionloop.quantities import FrictionloopError

CIRCLE = np.exp(1j * np.append(np.geomspace(1e-4, np.pi, 3000), 0.0))
seeds = st.integers(0, 2**32 - 1)


def plant(seed: int, n: int = 5, m: int = 3, p: int = 3, radius: float = 1.1) -> Quadruple:
    """A random plant, unstable by itself."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n))
    A *= radius / np.abs(np.linalg.eigvals(A)).max()
    D = rng.normal(size=(p + 1, m + 1))
    D[:p, m] += np.sign(D[:p, m])
    D[p, :m] += np.sign(D[p, :m])
    D[p, m] = 0.3
    return Quadruple(A, rng.normal(size=(n, m + 1)), rng.normal(size=(p + 1, n)), D)


def closed(P: Quadruple, K: Quadruple) -> Quadruple:
    """z from w with u = K y, by solving for u and y at every instant: no formula of the synthesis in it."""
    A, B, C, D = P
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


@settings(max_examples=15)
@given(seed=seeds)
def test_hinf_keeps_its_norm_and_is_stable(seed: int) -> None:
    P = plant(seed)
    controller, gamma = synthesise(P)
    loop = closed(P, controller)
    assert np.abs(np.linalg.eigvals(loop.A)).max() < 1
    assert norm(loop) <= gamma * (1 + 1e-6)


def test_nothing_that_is_given_is_changed() -> None:
    """SLICOT works in the arrays that it gets, of one row or one column too."""
    P = plant(4, radius=0.9)
    kept = [each.copy() for each in P]
    synthesise(P)
    balanced(bilinear(P))
    small = Quadruple(np.array([[-1.0]]), np.ones((1, 1)), np.full((1, 1), 2.0), np.zeros((1, 1)))
    balanced(small)
    for each, was in zip((*P, *small), (*kept, -1.0, 1.0, 2.0, 0.0), strict=True):
        assert np.array_equal(each, np.broadcast_to(was, each.shape))


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


def some_controller_keeps(P: Quadruple, gamma: float) -> bool:
    """Zhou, Doyle, Glover, Robust and Optimal Control, theorem 17.1, with D12 and D21 as they are."""
    A, B, C, D = bilinear(P)
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
    _, gamma = synthesise(P)
    assert some_controller_keeps(P, gamma)
    assert not some_controller_keeps(P, gamma / 1.01)


def test_without_slicot_the_extra_is_named(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "ctrlsys", None)
    with pytest.raises(FrictionloopError, match=r"^ctrlsys is missing; install with: .*'frictionloop\[design\]'$"):
        synthesise(plant(1))


def test_hinf_against_python_control() -> None:
    control = pytest.importorskip("control", reason="python-control is not installed")
    pytest.importorskip("slycot", reason="python-control's hinfsyn needs slycot, which is under the GPL")
    P = plant(3)
    _, _, gamma, _ = control.hinfsyn(control.ss(*bilinear(P)), 1, 1)
    assert synthesise(P)[1] == pytest.approx(gamma, rel=0.02)


def test_needs_weight_and_noise() -> None:
    P = plant(1)
    D = P.D.copy()
    D[:-1, -1] = 0.0
    moved = bilinear(bilinear(P)._replace(D=D), back=True)
    with pytest.raises(FrictionloopError, match="weight and noise"):
        synthesise(moved)


@settings(max_examples=30)
@given(seed=seeds)
def test_bilinear_keeps_the_response_and_returns(seed: int) -> None:
    system = plant(seed, radius=0.8)
    z = CIRCLE[:2000:50]
    moved = bilinear(system)
    assert moved.at((z - 1) / (z + 1)) == pytest.approx(system.at(z), rel=1e-6, abs=1e-8)
    for back, was in zip(bilinear(moved, back=True), system, strict=True):
        assert back == pytest.approx(was, rel=1e-6, abs=1e-8)


@settings(max_examples=30)
@given(seed=seeds, order=st.integers(1, 5))
def test_truncation_keeps_its_bound(seed: int, order: int) -> None:
    moved = bilinear(plant(seed, n=6, radius=0.9))
    small, sizes = balanced(moved, order)
    s = 1j * np.geomspace(1e-4, 1e4, 400)
    error = np.linalg.norm(moved.at(s) - small.at(s), 2, axis=(1, 2)).max()
    assert len(small.A) == order
    assert np.linalg.eigvals(small.A).real.max() < 0
    assert error <= 2 * sizes[order:].sum() * (1 + 1e-6) + 1e-9 * sizes[0]
