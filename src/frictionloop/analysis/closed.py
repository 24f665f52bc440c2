"""The sampled plant closed by a control law: the loop as a state space."""

from __future__ import annotations

import numpy as np

from frictionloop.analysis.state_space import StateSpace

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
