"""H-infinity synthesis by two Riccati equations, for a sampled plant, with nothing but scipy.

The sampled problem is carried to continuous time by z = (1 + w)/(1 - w), which keeps stability and every H-infinity
norm, solved there by the formulas of Glover and Doyle ("State-space formulae for all stabilizing controllers",
Systems & Control Letters 11, 1988; as printed in Zhou, Doyle, Glover, Robust and Optimal Control, theorem 17.1), and
carried back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, solve_continuous_are

from frictionloop.analysis.state_space import Array
from frictionloop.design.quadruple import Quadruple, bilinear
from frictionloop.quantities import FrictionloopError

GAMMA_RATIO = 1.01
"""Ratio of the norm asked for to one that no controller reaches, at which the search for gamma ends."""
RESIDUAL = 1e-9
"""What a Riccati equation may leave over, relative: rounding left up to 1e-11, no solution left 1e-4 and more."""


@dataclass(frozen=True, eq=False)
class Generalised:
    """A plant with inputs [w, u] and outputs [z, y]: the controller u = K y is to make z from w small."""

    system: Quadruple
    controls: int = 1
    """How many of the last inputs are u."""
    measurements: int = 1
    """How many of the last outputs are y."""


class Synthesis(NamedTuple):
    """A controller u = K y, and the norm it keeps."""

    controller: Quadruple
    gamma: float
    """Norm of z from w that the formulas promise."""


def synthesise(plant: Generalised, gamma: float | None = None) -> Synthesis:
    """Return the sampled controller with (nearly) the least H-infinity norm of z from w, or one with norm ``gamma``.

    Parameters
    ----------
    plant
        Sampled; D12 and D21 of its w-plane equivalent with full rank, as weights on u and a noise in y give them.
    gamma
        Norm to keep, above 0; None searches for the least one, to 1 %.

    Raises
    ------
    FrictionloopError
        No controller keeps the norm, or the Riccati equations have no usable solution.
    """
    continuous = _normalised(replace(plant, system=bilinear(plant.system)))
    found = _least(continuous) if gamma is None else _at(continuous, gamma)
    if found is None:
        asked = "any gamma up to 1e6" if gamma is None else f"gamma = {gamma:g}"
        raise FrictionloopError(
            f"the H-infinity synthesis does not converge for {asked}: no admissible solution of its Riccati equations"
        )
    return Synthesis(bilinear(continuous.restored(found.controller), back=True), found.gamma)


@dataclass(frozen=True, eq=False)
class _Normalised:
    """The plant with D12 = [0; 1], D21 = [0 1], D22 = 0, and what takes its controllers back."""

    A: Array
    B1: Array
    B2: Array
    C1: Array
    C2: Array
    D11: Array
    scale_u: Array
    scale_y: Array
    D22: Array

    def restored(self, K: Quadruple) -> Quadruple:
        """Return the controller of the plant as it was: gains undone, then D22 around it closed."""
        A, B, C, D = K.A, K.B @ self.scale_y, self.scale_u @ K.C, self.scale_u @ K.D @ self.scale_y
        inner = np.linalg.inv(np.eye(len(self.D22)) + self.D22 @ D)
        return Quadruple(A - B @ inner @ self.D22 @ C, B @ inner, C - D @ inner @ self.D22 @ C, D @ inner)


def _normalised(plant: Generalised) -> _Normalised:
    A, B, C, D = plant.system
    m2, p2 = plant.controls, plant.measurements
    m1, p1 = B.shape[1] - m2, C.shape[0] - p2
    q12, r12 = np.linalg.qr(D[:p1, m1:], mode="complete")
    q21, r21 = np.linalg.qr(D[p1:, :m1].T, mode="complete")
    if min(np.abs(np.diag(r12)).min(), np.abs(np.diag(r21)).min()) < 1e-12:
        raise FrictionloopError("the H-infinity synthesis needs a weight on every command and a noise in every reading")
    rows, columns = np.roll(q12, p1 - m2, axis=1), np.roll(q21, m1 - p2, axis=1)
    scale_u, scale_y = np.linalg.inv(r12[:m2]), np.linalg.inv(r21[:p2].T)
    return _Normalised(
        A=A,
        B1=B[:, :m1] @ columns,
        B2=B[:, m1:] @ scale_u,
        C1=rows.T @ C[:p1],
        C2=scale_y @ C[p1:],
        D11=rows.T @ D[:p1, :m1] @ columns,
        scale_u=scale_u,
        scale_y=scale_y,
        D22=D[p1:, m1:],
    )


def _least(plant: _Normalised) -> Synthesis | None:
    """Return a controller with nearly the least gamma, by bisection of its logarithm."""
    low, high, best = 0.0, 1.0, _at(plant, 1.0)
    while best is None and high < 1e6:
        low, high = high, 10.0 * high
        best = _at(plant, high)
    while low == 0.0 and high > 1e-6:
        trial = _at(plant, high / 10.0)
        low, high, best = (low, high / 10.0, trial) if trial else (high / 10.0, high, best)
    while best is not None and low > 0 and high > GAMMA_RATIO * low:
        middle = np.sqrt(low * high)
        trial = _at(plant, middle)
        low, high, best = (low, middle, trial) if trial else (middle, high, best)
    return best


def _at(plant: _Normalised, gamma: float) -> Synthesis | None:
    """Return the central controller for gamma, None where there is none."""
    A, B1, B2, C1, C2, D11 = plant.A, plant.B1, plant.B2, plant.C1, plant.C2, plant.D11
    (p1, m1), m2, p2 = D11.shape, B2.shape[1], C2.shape[0]
    a, b = p1 - m2, m1 - p2
    D1111, D1112, D1121, D1122 = D11[:a, :b], D11[:a, b:], D11[a:, :b], D11[a:, b:]
    if gamma <= max(np.linalg.norm(D11[:a], 2), np.linalg.norm(D11[:, :b], 2)):
        return None
    B, C = np.hstack([B1, B2]), np.vstack([C1, C2])
    row = np.hstack([D11, np.vstack([np.zeros((a, m2)), np.eye(m2)])])
    column = np.vstack([D11, np.hstack([np.zeros((p2, b)), np.eye(p2)])])
    R = row.T @ row - np.diag([gamma**2] * m1 + [0.0] * m2)
    S = column @ column.T - np.diag([gamma**2] * p1 + [0.0] * p2)
    X = _stabilising(A, B, C1.T @ row, R, C1.T @ C1)
    Y = _stabilising(A.T, C.T, B1 @ column.T, S, B1 @ B1.T)
    if X is None or Y is None or np.abs(np.linalg.eigvals(X @ Y)).max() >= gamma**2:
        return None
    F = -np.linalg.solve(R, row.T @ C1 + B.T @ X)
    L = -np.linalg.solve(S, column @ B1.T + C @ Y).T
    F12, F2, L12, L2 = F[b:m1], F[m1:], L[:, a:p1], L[:, p1:]
    Z = np.linalg.inv(np.eye(len(A)) - Y @ X / gamma**2)
    through = -D1121 @ D1111.T @ np.linalg.inv(gamma**2 * np.eye(a) - D1111 @ D1111.T) @ D1112 - D1122
    # B2 D12^-1 and D21^-1 C2 of the book: the square roots D12, D21 cancel in the central controller.
    drive, seen = Z @ (B2 + L12), -(C2 + F12)
    Bk = -Z @ L2 + drive @ through
    return Synthesis(Quadruple(A + B @ F + Bk @ seen, Bk, F2 + through @ seen, through), float(gamma))


def _stabilising(A: Array, B: Array, S: Array, R: Array, Q: Array) -> Array | None:
    """Return X >= 0 of A'X + XA + Q - (XB + S) R^-1 (XB + S)' = 0 with A - B R^-1 (XB + S)' stable, R indefinite."""
    try:
        X = solve_continuous_are(A, B, Q, R, s=S)
    except (LinAlgError, ValueError):
        return None
    if not np.all(np.isfinite(X)) or np.linalg.eigvalsh(X).min() < -1e-7 * max(np.abs(X).max(), 1e-300):
        return None
    # Below the least gamma eigenvalues of the Hamiltonian lie on the imaginary axis, and what the solver then returns
    # neither solves the equation nor stabilises.
    gain = np.linalg.solve(R, (X @ B + S).T)
    parts = (A.T @ X, X @ A, Q, (X @ B + S) @ gain)
    left = np.abs(parts[0] + parts[1] + parts[2] - parts[3]).max()
    stable = np.linalg.eigvals(A - B @ gain).real.max() < 0.0
    return np.asarray(X) if stable and left <= RESIDUAL * max(np.abs(part).max() for part in parts) else None
