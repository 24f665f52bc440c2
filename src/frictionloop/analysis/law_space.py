"""A control law for small signals: its step's Jacobian at rest by differences, and the overdrive, as a state space."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictionloop.analysis.controller_rest import LawStep, Rest, rest_of, sizes
from frictionloop.analysis.loop_elements import Elements
from frictionloop.analysis.sampled_plant import SampledPlant
from frictionloop.analysis.state_space import StateSpace
from frictionloop.control.lookup import overdrive_gains
from frictionloop.control.pi import is_pi
from frictionloop.parameters import Controller, System
from frictionloop.quantities import Array, FrictionloopError

INPUTS = ("f_r", "f_m")
OUTPUTS = ("u", "c")
IDLE = 1.0 + 1e-6
"""Largest |pole| of states that may be left out when nothing moves them or they move nothing."""


def law_space(system: System, loop: Elements, plant: SampledPlant) -> StateSpace:
    """Return a System's control law for small signals around an operating point.

    x[k+1] = A x[k] + B [f_r, f_m][k], [u, c][k] = C x[k] + D [f_r, f_m][k], where c is what the plant gets of the
    force command u: the same, or behind the overdrive c = (u[k] - p u[k-1])/(1 - p), which in amplitude is
    (a_w - p a)/(1 - p) (control/lookup). PI has it in closed form; of any other law it is the Jacobian of the
    compiled step at rest (analysis/rest) at the finger's steady speed and load.

    Parameters
    ----------
    system
        The loop.
    loop, plant
        Its elements at the operating point, and sampled.

    Raises
    ------
    FrictionloopError
        The law has no rest there, is saturated there, or is not smooth but for the edge of its clamp.
    """
    controller = system.controller
    if is_pi(controller):
        return pi_space(controller.kp, controller.ki, plant.period_s)
    space = jacobian_space(rest_of(system, loop, plant))
    return overdriven(space, controller)


def pi_space(kp: float, ki: float, period_s: float) -> StateSpace:
    """Return e = f_r - f_m, u = kp e + I, I[k+1] = I[k] + ki Ts e; I is a state only when ki is not 0."""
    integrals, error = int(ki != 0), np.array([[1.0, -1.0]])
    return StateSpace(
        A=np.eye(integrals),
        B=np.ones((integrals, 1)) @ (ki * period_s * error),
        C=np.ones((2, integrals)),
        D=kp * np.vstack([error, error]),
        period_s=period_s,
        inputs=INPUTS,
        outputs=OUTPUTS,
    )


def jacobian_space(rest: Rest) -> StateSpace:
    """Return the law around its rest, without states that are idle there."""
    what = f'controller.kind = "{rest.kind}"'
    try:
        matrix = jacobian(rest.step, rest.point, what)
    except FrictionloopError:
        matrix = jacobian(rest.step.opened(), rest.point, what)
        if not _on_one_side(matrix, rest):
            raise
    A, B, C, D = matrix[:-1, :-2], matrix[:-1, -2:], matrix[-1:, :-2], matrix[-1:, -2:]
    kept = _at_work(A, B, C)
    A, B, C = A[np.ix_(kept, kept)], B[kept], C[:, kept]
    return StateSpace(A, B, np.vstack([C, C]), np.vstack([D, D]), rest.step.period_s, INPUTS, OUTPUTS)


def _on_one_side(matrix: Array, rest: Rest) -> bool:
    """Tell whether a law at the edge of its clamp has these slopes to at least one side, which is the inside."""
    step, point = rest.step, rest.point
    centre, shifts, out = step(point), SIDE * sizes(point), np.append(sizes(point[:-2]), sizes(point[-1:]))
    for slopes, shift, way in zip(matrix.T, shifts, np.eye(point.size), strict=True):
        sides = [(step(point + sign * shift * way) - centre) / (sign * shift) for sign in (1.0, -1.0)]
        size = shift / SIDE / out
        largest = max(1.0, float(np.max(np.abs(slopes) * size)))
        if not any(np.max(np.abs(side - slopes) * size) <= KINK * largest for side in sides):
            return False
    return True


def overdriven(space: StateSpace, controller: Controller) -> StateSpace:
    """Return a law with c behind the overdrive, if its parameters say so; the last u is a further state."""
    decay = overdrive_gains(controller).decay
    if decay == 0.0:
        return space
    size, ahead = len(space.A), 1.0 / (1.0 - decay)
    u, through = space.C[:1], space.D[:1]
    return StateSpace(
        A=np.block([[space.A, np.zeros((size, 1))], [u, np.zeros((1, 1))]]),
        B=np.vstack([space.B, through]),
        C=np.block([[u, np.zeros((1, 1))], [ahead * u, np.full((1, 1), -decay * ahead)]]),
        D=np.vstack([through, ahead * through]),
        period_s=space.period_s,
        inputs=INPUTS,
        outputs=OUTPUTS,
    )


def _at_work(A: Array, B: Array, C: Array) -> NDArray[np.intp]:
    """Return the indices of the states that an input moves and that move the output, by who acts on whom.

    The others must not count as instability with a pole at 1, like an integrator whose gain is 0. A state that grows
    by itself is no such thing: then all are kept.
    """
    size = len(A)
    acts = (A != 0.0).astype(float)  # who (column) acts on whom (row)
    reached, seen = np.any(B != 0.0, axis=1), np.any(C != 0.0, axis=0)
    for _ in range(size):
        reached, seen = reached | (acts @ reached > 0), seen | (acts.T @ seen > 0)
    kept, left = np.flatnonzero(reached & seen), np.flatnonzero(~(reached & seen))
    growing = bool(left.size) and float(np.max(np.abs(np.linalg.eigvals(A[np.ix_(left, left)])))) > IDLE
    return np.arange(size) if growing else kept


FINEST, COARSEST, SHARES = 1e-8, 1e-3, 11
"""Steps of the differences over the size of what is varied: rounding limits small ones, curvature large ones."""
ALIKE, KINK = 1e-5, 1e-3
"""How far two neighbouring steps may differ, and the slopes on both sides, relative to the largest slope."""
SIDE = 1e-6
"""Step, over the size of what is varied, by which a law is looked at to either side of the edge of its clamp."""
STRAIGHT = 1e-11
"""How far slopes over the two coarsest steps, and to both sides, may differ of a law that is a straight line there."""
NOTHING = 1e-11
"""A slope below this, in sizes over sizes, is rounding."""


def jacobian(step: LawStep, point: Array, what: str) -> Array:
    """Return d(x', u)/d(x, f_r, f_m) at a point, shape (states + 1, states + 2).

    Per column the step is the one whose result differs least from that of the next finer one. A law is smooth where
    such a step is found and the slopes to both sides agree: sign(s) and sqrt|s| of a sliding mode grow without
    bound as the step shrinks, |s| has two slopes. A straight line has the same slope over the coarsest steps, and
    finer ones are not looked at.

    Raises
    ------
    FrictionloopError
        The law is not smooth at the point.
    """
    out = np.append(sizes(point[:-2]), sizes(point[-1:]))
    centre, size = step(point), sizes(point)
    columns = [_column(step, point, centre, j, size[j], out) for j in range(point.size)]
    if any(column is None for column in columns):
        raise FrictionloopError(f"{what}: not smooth at rest; simulate it")
    return np.column_stack([column for column in columns if column is not None])


def _column(step: LawStep, point: Array, centre: Array, j: int, size: float, out: Array) -> Array | None:
    shares = np.geomspace(COARSEST, FINEST, SHARES)
    slopes, kinks = np.empty((2, SHARES, centre.size))
    scaled = size / out
    for k, share in enumerate(shares):
        ahead, behind = point.copy(), point.copy()
        ahead[j] += share * size
        behind[j] -= share * size
        forward, backward = step(ahead), step(behind)
        slopes[k] = (forward - backward) / (ahead[j] - behind[j])
        kinks[k] = (forward - 2.0 * centre + backward) / (share * size)
        if k == 1 and max(np.max(np.abs(each) * scaled) for each in (slopes[1] - slopes[0], *kinks[:2])) <= STRAIGHT:
            return np.where(np.abs(slopes[0]) * scaled < NOTHING, 0.0, slopes[0])
    apart = np.max(np.abs(np.diff(slopes, axis=0)) * scaled, axis=1)
    bends = np.max(np.abs(kinks) * scaled, axis=1)[:-1]
    largest = max(1.0, float(np.max(np.abs(slopes[SHARES // 2]) * scaled)))
    smooth = (apart <= ALIKE * largest) & (bends <= KINK * largest)
    if not smooth.any():
        return None
    best = int(np.argmin(np.where(smooth, apart, np.inf)))
    return np.where(np.abs(slopes[best]) * scaled < NOTHING, 0.0, slopes[best])
