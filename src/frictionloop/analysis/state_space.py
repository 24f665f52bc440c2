"""A discrete-time linear system in state space, with names for what goes in and out; a plant that a law closes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve_discrete_lyapunov

from frictionloop.quantities import Array, Complex


@dataclass(frozen=True, eq=False)
class StateSpace:
    """x[k+1] = A x[k] + B w[k], y[k] = C x[k] + D w[k], one step per control period."""

    A: Array
    """Transition, shape (states, states)."""
    B: Array
    """Inputs to states, shape (states, inputs)."""
    C: Array
    """States to outputs, shape (outputs, states)."""
    D: Array
    """Inputs to outputs of the same instant, shape (outputs, inputs)."""
    period_s: float
    """Control period Ts."""
    inputs: tuple[str, ...]
    """Names of w, in N."""
    outputs: tuple[str, ...]
    """Names of y, in N."""

    def driven_by(self, inputs: tuple[str, ...]) -> StateSpace:
        """Return the same system with these of its inputs alone, in this order."""
        columns = [self.inputs.index(name) for name in inputs]
        return replace(self, B=self.B[:, columns], D=self.D[:, columns], inputs=inputs)

    def poles(self) -> Complex:
        """Return the eigenvalues of A; the system is stable when all lie inside the unit circle."""
        return np.linalg.eigvals(self.A).astype(complex)

    def is_stable(self) -> bool:
        """Return whether every pole lies inside the unit circle."""
        return bool(np.all(np.abs(self.poles()) < 1.0))

    def response(self, frequency_hz: ArrayLike) -> Complex:
        """Return C (z - A)^-1 B + D at z = exp(j 2 pi f Ts), shape (frequencies, outputs, inputs), f in Hz."""
        turn = 2j * np.pi * self.period_s * np.atleast_1d(np.asarray(frequency_hz, dtype=float))
        eye = np.eye(len(self.A))
        # z - A = (z - 1) - (A - 1): an integrator's z - 1 keeps its digits at low frequencies.
        inner = np.expm1(turn)[:, None, None] * eye - (self.A - eye)
        return np.asarray(self.C @ np.linalg.solve(inner, np.broadcast_to(self.B, (turn.size, *self.B.shape))) + self.D)

    def variance(self, source: str) -> dict[str, float]:
        """Return the stationary variance of every output, per unit variance of one input drawn anew each period.

        X = A X A' + b b' gives c X c' + d^2 for an output (c, d); infinite when the system is not stable.
        """
        if not self.is_stable():
            return dict.fromkeys(self.outputs, float("inf"))
        column = self.inputs.index(source)
        drive = self.B[:, column]
        spread = solve_discrete_lyapunov(self.A, np.outer(drive, drive))
        powers = np.einsum("ij,jk,ik->i", self.C, spread, self.C) + self.D[:, column] ** 2
        # Rounding of the Lyapunov equation leaves something beside a variance of 0, on either side of it.
        states = len(self.A)
        rounding = states**2 * np.finfo(float).eps * np.linalg.norm(spread, 2) * np.sum(self.C**2, axis=1)
        return dict(zip(self.outputs, map(float, np.where(powers > rounding, powers, 0.0)), strict=True))


INPUTS = ("f_r", "d", "n", "q")
"""Set-point, disturbance, noise before the sensor's pole, error of the reading (a converter's rounding)."""
OUTPUTS = ("f_a", "f_m", "u")


def close(plant: StateSpace, law: StateSpace) -> StateSpace:
    """Return the loop of a control law around a plant.

    Parameters
    ----------
    plant
        Inputs u, d, n and outputs f_a, f_m, in that order, without a direct path from u.
    law
        Inputs f_r, f_m and outputs u, c: the force command, and what the plant gets of it behind the overdrive
        (analysis/law_space).

    Returns
    -------
    StateSpace
        Inputs f_r, d, n, q and outputs f_a, f_m, u: the values at t_k, before the update, with the u computed there.
    """
    states = len(law.A)
    command, f_m, late = plant.B[:, :1], plant.C[1:], law.C[1:]
    # Reading f_m + q over the states [plant, law] and over the inputs; from it u and c.
    read_x = np.hstack([f_m, np.zeros((1, states))])
    read_w = np.hstack([np.zeros((1, 1)), plant.D[1:, 1:], np.ones((1, 1))])
    set_w = np.array([[1.0, 0.0, 0.0, 0.0]])
    said_x = law.D[:, 1:] @ read_x + np.hstack([np.zeros((2, len(plant.A))), law.C])
    said_w = law.D[:, 1:] @ read_w + law.D[:, :1] @ set_w
    free = np.block([[plant.A, command @ late], [np.zeros((states, len(plant.A))), law.A]])
    free[: len(plant.A)] += command @ (law.D[1:, 1:] @ read_x)
    free[len(plant.A) :] += law.B[:, 1:] @ read_x
    driven = np.hstack([np.zeros((len(plant.A), 1)), plant.B[:, 1:], np.zeros((len(plant.A), 1))])
    f_a_x, f_a_w = np.hstack([plant.C[:1], np.zeros((1, states))]), np.hstack([[[0.0]], plant.D[:1, 1:], [[0.0]]])
    return StateSpace(
        A=free,
        B=np.vstack([driven + command @ said_w[1:], law.B[:, 1:] @ read_w + law.B[:, :1] @ set_w]),
        C=np.vstack([f_a_x, read_x, said_x[:1]]),
        D=np.vstack([f_a_w, read_w, said_w[:1]]),
        period_s=plant.period_s,
        inputs=INPUTS,
        outputs=OUTPUTS,
    )
