"""The plant of a synthesis: the sampled loop with an integrator, and weights on what is to be small.

Inputs  w_res, w_in, w_d, w_n, u     Outputs  z_res, z_e, z_u, y
    w_res    force on the suspension that a resonance off its value brings about: loop closed by -delta z_res
    w_in     force command of another's making, before the integrator
    w_d      friction force of another's making, from all frequencies alike
    w_n      sensor noise
    z_res    2 r (f_m - f_a): what the springs do with a resonance off by r
    z_e      residual f_a, weighted as the disturbance's spectrum: a multiple of the shaping filter, plus a floor
    z_u      force command
y = -f_m, and the synthesised K acts before 1 + wi Ts/(z - 1): kp = 1 and ki = wi of the PI behind it are then known
beforehand, and no integrator has to come out of an optimisation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from frictionloop.analysis.sampled import SampledPlant
from frictionloop.design.noise_model import STATES
from frictionloop.design.slicot import Quadruple, balanced, bilinear
from frictionloop.quantities import FrictionloopError

MOST_STATES = 120
"""Most states of the generalised plant: a synthesis then takes 7 s of one thread (measured), a dozen times a search."""


@dataclass(frozen=True)
class Weights:
    """How much each signal of the generalised plant counts.

    The contact is believed so fast that little lead is spent on it, at any slip length. Chosen by a search on
    simulated fingers (studies/pages/beliefs.md).
    """

    performance: float = 680.0
    """Factor on the shaping filter: where the norm is 1, S lets through a residual of 1/performance N/rtHz."""
    floor: float = 0.444
    """Weight on S where there is no disturbance: where the norm is 1, its inverse is the largest |S|."""
    resonance: float = 8.6e-5
    """Share r by which the resonance may be off (complex, so far smaller than the real share that is held)."""
    split: float = 0.0077
    """How the weight of the resonance is shared: w_res times it, z_res over it."""
    effort: float = 0.296
    """Weight on K S: its inverse bounds the controller's gain where S is 1."""
    entry: float = 0.05
    """Size of w_in."""
    noise: float = 0.0149
    """Size of w_n."""
    integral_hz: float = 6.6
    """Corner wi / (2 pi) of the PI behind K."""
    resonance_bias: float = -0.07
    """Share by which the believed resonance lies off the bench's: below is harmless, above is not."""
    contact_faster: float = 3.0
    """Factor by which the believed pole of the contact lies above the bench's."""


def weighted_plant(plant: SampledPlant, shaping: Quadruple, weights: Weights) -> Quadruple:
    """Return the generalised plant, sampled, of a loop (u, d, n to f_a, f_m) under weights; the filter is in s."""
    space, half_s = plant.state_space(), plant.period_s / 2
    in_w = shaping._replace(A=shaping.A * half_s, B=shaping.B * half_s)  # Tustin's rule, s = (2/Ts) w
    weight = bilinear(balanced(in_w)[0], back=True)
    sizes = np.array([[weights.split, weights.entry, 1.0, weights.noise, 1.0]])
    x, i, e = (np.zeros((1, len(each))) for each in (space.A, [1.0], weight.A))  # nothing of a state
    u, d, f_a, f_m = space.B[:, :1], space.B[:, 1:2], space.C[:1], space.C[1:]
    # The disturbance passes to f_a at once; what pushes the suspension alone does not.
    a_w = np.array([[space.D[0, 1] - 1.0, 0.0, space.D[0, 1], 0.0, 0.0]]) * sizes
    m_w = np.array([[space.D[1, 1], 0.0, space.D[1, 1], 1.0, 0.0]]) * sizes
    x_w, command = np.hstack([d, u, d, 0 * d, u]) * sizes, np.array([[0.0, 1.0, 0.0, 0.0, 1.0]]) * sizes
    through, swing = weights.performance * weight.D + weights.floor, 2 * weights.resonance / weights.split
    A = np.block([[space.A, u, x.T @ e], [x, i + 1.0, e], [weight.B @ f_a, e.T, weight.A]])
    B = np.vstack([x_w, 2 * math.pi * weights.integral_hz * plant.period_s * command, weight.B @ a_w])
    C = np.block(
        [
            [swing * (f_m - f_a), i, e],
            [through * f_a, i, weights.performance * weight.C],
            [x, i + weights.effort, e],
            [-f_m, i, e],
        ]
    )
    return Quadruple(A, B, C, np.vstack([swing * (m_w - a_w), through * a_w, weights.effort * command, -m_w]))


def check_order(plant: SampledPlant, delay_s: float, shaping_states: int = STATES) -> None:
    """Refuse a delay, a state for each of its control periods, that takes the generalised plant above `MOST_STATES`."""
    late = plant.delay_states
    others = len(plant.transition) + 1 + shaping_states  # 1: the integrator
    if others + late > MOST_STATES:
        raise FrictionloopError(
            f"controller.delay_s = {delay_s:g} s: at most {(MOST_STATES - others) * plant.period_s:g} s"
        )
