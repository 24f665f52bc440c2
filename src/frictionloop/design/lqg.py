"""LQG: a Kalman filter and a linear-quadratic regulator on the same weighted plant as the H-infinity synthesis.

The central controller of the H2 problem (Zhou, Doyle, Glover, Robust and Optimal Control, ch. 14, in discrete time): x
from a stationary Kalman filter, u = -F x. The disturbance's shaping filter enters as process noise, or as a weight on
the residual, whichever the plant has.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import LinAlgError, solve_discrete_are

from frictionloop.design.quadruple import Quadruple
from frictionloop.design.riccati import Generalised
from frictionloop.quantities import FrictionloopError


def lqg(plant: Generalised) -> Quadruple:
    """Return the sampled controller u = K y that minimises the sum of squares of z for white w, with no delay left out.

    The regulator acts on the estimate that contains the present measurement, so K has a direct path.

    Parameters
    ----------
    plant
        Sampled, with a weight on every command and noise in every measurement.

    Raises
    ------
    FrictionloopError
        One of the two Riccati equations has no stabilising solution.
    """
    A, B, C, D = plant.system
    m, p = B.shape[1] - plant.controls, C.shape[0] - plant.measurements
    B1, B2, C1, C2 = B[:, :m], B[:, m:], C[:p], C[p:]
    D12, D21, D22 = D[:p, m:], D[p:, :m], D[p:, m:]
    if np.any(D22):
        raise FrictionloopError("LQG: the command must not reach the measurement within one period")
    try:
        X = solve_discrete_are(A, B2, C1.T @ C1, D12.T @ D12, s=C1.T @ D12)
        Y = solve_discrete_are(A.T, C2.T, B1 @ B1.T, D21 @ D21.T, s=B1 @ D21.T)
    except (LinAlgError, ValueError) as error:
        raise FrictionloopError(f"the LQG synthesis does not converge: {error}") from None
    inner = D12.T @ D12 + B2.T @ X @ B2
    regulator = np.linalg.solve(inner, B2.T @ X @ A + D12.T @ C1)
    spread = np.linalg.inv(C2 @ Y @ C2.T + D21 @ D21.T)
    predictor = (A @ Y @ C2.T + B1 @ D21.T) @ spread
    update = Y @ C2.T @ spread
    # w that is seen in y acts in this period too: its estimate is D21' spread (y - C2 x).
    seen = np.linalg.solve(inner, (B2.T @ X @ B1 + D12.T @ D[:p, :m]) @ D21.T) @ spread
    direct = -(regulator @ update + seen)
    state = -regulator - direct @ C2
    closed = A + B2 @ state - predictor @ C2
    return Quadruple(closed, predictor + B2 @ direct, state, direct)
