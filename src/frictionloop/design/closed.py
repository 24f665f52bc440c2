"""The sampled plant closed by the PI law: the loop as a state space."""

from __future__ import annotations

import numpy as np

from frictionloop.design.state_space import StateSpace

INPUTS = ("f_r", "d", "n")
OUTPUTS = ("f_a", "f_m", "u")


def close(plant: StateSpace, kp: float, ki: float) -> StateSpace:
    """Return the loop e = f_r - f_m, u = kp e + I, I[k+1] = I[k] + ki Ts e around a plant.

    The integral is a state only when ki is not 0, so that its idle pole at 1 does not count as instability.

    Parameters
    ----------
    plant
        Inputs u, d, n and outputs f_a, f_m, in that order, without a direct path from u.
    kp
        Proportional gain, N/N.
    ki
        Integral gain, 1/s.

    Returns
    -------
    StateSpace
        Inputs f_r, d, n and outputs f_a, f_m, u: the values at t_k, before the update, with the u computed there.
    """
    states, integrals = len(plant.A), int(ki != 0)
    command, f_m = plant.B[:, :1], plant.C[1:]
    # e and u as rows over the states [x, I] and over the inputs [f_r, d, n].
    e_x = np.hstack([-f_m, np.zeros((1, integrals))])
    e_w = np.hstack([np.ones((1, 1)), -plant.D[1:, 1:]])
    u_x = kp * e_x + np.hstack([np.zeros((1, states)), np.ones((1, integrals))])
    u_w = kp * e_w
    free = np.block([[plant.A, np.zeros((states, integrals))], [np.zeros((integrals, states)), np.eye(integrals)]])
    driven = np.hstack([np.zeros((states, 1)), plant.B[:, 1:]])
    error_in = np.full((integrals, 1), ki * plant.period_s)
    outputs = np.hstack([plant.C, np.zeros((2, integrals))])
    through = np.hstack([np.zeros((2, 1)), plant.D[:, 1:]])
    return StateSpace(
        A=free + np.vstack([command @ u_x, error_in @ e_x]),
        B=np.vstack([driven + command @ u_w, error_in @ e_w]),
        C=np.vstack([outputs, u_x]),
        D=np.vstack([through, u_w]),
        period_s=plant.period_s,
        inputs=INPUTS,
        outputs=OUTPUTS,
    )
