"""What the three laws of the contact share: the state of tip and bristle, and the coefficients of a step.

A step takes the friction limit and the bone's speed in the middle of the step (or their means over it) and returns the
mean force over the step. Inside, forces are counted in the deflection of the bristle, F/s0, and speeds in the way
covered in a step, so that a law needs one division per pass. docs/contact.md derives them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionloop.parameters import Skin
from frictionloop.physics.skin import SKIN_DAMPING_N_S_PER_M, SKIN_MASS_KG, SKIN_STIFFNESS_N_PER_M
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.checks import ABOVE_0, numbers

BRISTLE_STIFFNESS_N_PER_M, BRISTLE_DAMPING_N_S_PER_M = Skin().bristle_stiffness_n_m, Skin().bristle_damping_n_s_m
"""s0 and s1 where none are given; sources in parameters/finger."""
LEAST_LIMIT_M = 1e-18
"""Deflection at the limit below which a step would divide by zero; 2e-14 N with s0 = 2e4 N/m, far below any force."""


class ContactState(NamedTuple):
    """Where tip and bristle are; the same for every law, all zero for a finger off the glass at rest."""

    lag_m: float
    """x, of the tip behind the bone."""
    lag_speed_m_s: float
    """x'."""
    bristle_m: float
    """Deflection z of the bristle."""
    limit_m: float = 0.0
    """Deflection Fc/s0 at the limit of the last step; the slider alone looks at it."""


class ContactCoefficients(NamedTuple):
    """Constants of a step, numbers or arrays over lanes.

    A = 1 / (2 m/dt + c + k dt/2) is the skin's mean speed per newton of mean force.
    """

    dt: float
    two_per_dt: float
    inertia: float
    """2 m A."""
    elastic: float
    """dt k A."""
    coupling: float
    """B = dt s0 A: way the tip yields in a step, over the deflection of the bristle that makes it yield."""
    stuck: float
    """1 / (1 + B/2), a bristle that sticks."""
    bristle: float
    """s0 in N/m."""
    per_bristle: float
    damping: float
    """G = s1 / (s0 dt)."""
    guard: float
    """What holds LuGre's damping below 4 Fc/|v|: equal to ``damping``; 0 would leave s1 as it is, and not passive."""


def contact_coefficients(
    dt: np.ndarray | float,
    skin_stiffness_n_per_m: np.ndarray | float = SKIN_STIFFNESS_N_PER_M,
    skin_damping_n_s_per_m: np.ndarray | float = SKIN_DAMPING_N_S_PER_M,
    skin_mass_kg: np.ndarray | float = SKIN_MASS_KG,
    bristle_stiffness_n_per_m: np.ndarray | float = BRISTLE_STIFFNESS_N_PER_M,
    bristle_damping_n_s_per_m: np.ndarray | float = BRISTLE_DAMPING_N_S_PER_M,
) -> ContactCoefficients:
    """Return the constants of `dahl_step`, `lugre_step` and `slider_step`; an array has the same bits as its numbers.

    Parameters
    ----------
    dt : array or float
        Length of a step in s, above 0. Any length is stable; docs/contact.md says how accurate.
    skin_stiffness_n_per_m, skin_damping_n_s_per_m, skin_mass_kg : array or float
        k > 0, c >= 0 and m > 0 of the skin in N/m, N s/m and kg.
    bristle_stiffness_n_per_m : array or float
        s0 > 0 in N/m.
    bristle_damping_n_s_per_m : array or float
        s1 >= 0 in N s/m, used by LuGre alone. Any value gives a passive contact (see `lugre_step`).

    Raises
    ------
    FrictionloopError
        For a value that is not finite or out of range, or shapes that do not broadcast.
    """
    given = [
        numbers("dt", dt, "s", ABOVE_0),
        numbers("skin_stiffness_n_per_m", skin_stiffness_n_per_m, "N/m", ABOVE_0),
        numbers("skin_damping_n_s_per_m", skin_damping_n_s_per_m, "N s/m", 0.0),
        numbers("skin_mass_kg", skin_mass_kg, "kg", ABOVE_0),
        numbers("bristle_stiffness_n_per_m", bristle_stiffness_n_per_m, "N/m", ABOVE_0),
        numbers("bristle_damping_n_s_per_m", bristle_damping_n_s_per_m, "N s/m", 0.0),
    ]
    try:
        h, k, c, m, s0, s1 = np.broadcast_arrays(*given)
    except ValueError:
        shapes = ", ".join(str(values.shape) for values in given)
        raise FrictionloopError(f"contact coefficients of shapes {shapes}: must be numbers or of one shape") from None
    yielding = 1.0 / (2.0 * m / h + c + k * h / 2.0)
    coupling, damping = h * s0 * yielding, s1 / (s0 * h)
    values = {
        "dt": h,
        "two_per_dt": 2.0 / h,
        "inertia": 2.0 * m * yielding,
        "elastic": h * k * yielding,
        "coupling": coupling,
        "stuck": 1.0 / (1.0 + coupling / 2.0),
        "bristle": s0,
        "per_bristle": 1.0 / s0,
        "damping": damping,
        "guard": damping,
    }
    return ContactCoefficients(**(values if h.shape else {name: float(value) for name, value in values.items()}))
