"""The two syntheses: norms on a dense grid, closed-loop poles, H2 optimality, and against SLICOT where present."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_lyapunov

from frictionloop.design.lqg import lqg
from frictionloop.design.quadruple import Quadruple, balanced, bilinear, realised, series
from frictionloop.design.riccati import Generalised, synthesise
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


@pytest.mark.parametrize("seed", range(8))
def test_hinf_against_slicot(seed: int) -> None:
    ctrlsys = pytest.importorskip("ctrlsys", reason="ctrlsys (SLICOT) is not installed")
    P = plant(seed)
    moved = (np.asfortranarray(x) for x in bilinear(P.system))
    n, m, p = len(P.system.A), P.system.B.shape[1], P.system.C.shape[0]
    *_, gamma, _, info = ctrlsys.sb10ad(1, n, m, p, 1, 1, *moved, 1e4, 1e-4, 0.0)
    assert info == 0
    assert synthesise(P).gamma == pytest.approx(gamma, rel=0.012)


@pytest.mark.parametrize("seed", range(8))
def test_lqg_against_slicot(seed: int) -> None:
    ctrlsys = pytest.importorskip("ctrlsys", reason="ctrlsys (SLICOT) is not installed")
    P = plant(seed, d22=0.0)
    # SB10ED wants D11 = 0; the controller depends on D11 only through what is seen of w.
    D = P.system.D.copy()
    D[:-1, :-1] = 0.0
    P = Generalised(P.system._replace(D=D))
    n, m, p = len(P.system.A), P.system.B.shape[1], P.system.C.shape[0]
    ak, bk, ck, dk, *_, info = ctrlsys.sb10ed(n, m, p, 1, 1, *(np.asfortranarray(x) for x in P.system))
    assert info == 0
    theirs = Quadruple(ak, np.reshape(bk, (n, 1)), np.reshape(ck, (1, n)), np.reshape(dk, (1, 1)))
    assert lqg(P).at(CIRCLE) == pytest.approx(theirs.at(CIRCLE), rel=1e-6, abs=1e-9)


def test_hinf_against_python_control() -> None:
    control = pytest.importorskip("control", reason="python-control is not installed")
    pytest.importorskip("slycot", reason="python-control's hinfsyn needs slycot, which is under the GPL")
    P = plant(3)
    _, _, gamma, _ = control.hinfsyn(control.ss(*bilinear(P.system)), 1, 1)
    assert synthesise(P).gamma == pytest.approx(gamma, rel=0.02)


def test_no_controller_below_the_least_gamma() -> None:
    P = plant(1)
    with pytest.raises(FrictionloopError, match=r"does not converge for gamma = .*Riccati equations$"):
        synthesise(P, 0.97 * synthesise(P).gamma)


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
