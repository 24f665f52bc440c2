"""Small signals at steady sliding: from the friction limit to the force, for each law.

There v (1 - s0 z sign(v)/Fc) = 0, so the force does not feel small changes of speed: the skin drops out, and holds
again only where the force would have to rise faster than the skin allows (docs/contact.md).
"""

from __future__ import annotations

import math

from frictionloop.physics.contact import BRISTLE_DAMPING_N_S_PER_M, BRISTLE_STIFFNESS_N_PER_M
from frictionloop.quantities import FrictionloopError, Lti
from frictionloop.quantities.checks import ABOVE_0, number


def linearise_dahl(
    limit_n: float, speed_m_s: float, bristle_stiffness_n_per_m: float = BRISTLE_STIFFNESS_N_PER_M
) -> Lti:
    """Return F/Fc = 1 / (1 + s T), T = Fc/(s0 |v|): a pole at s0 |v|/Fc.

    Parameters
    ----------
    limit_n
        Friction limit Fc in N, above 0.
    speed_m_s
        Speed v of the bone in m/s, not 0.
    bristle_stiffness_n_per_m
        s0 in N/m, above 0.

    Raises
    ------
    FrictionloopError
        For a value out of range.
    """
    return Lti((1.0,), (_relaxation_s(limit_n, speed_m_s, bristle_stiffness_n_per_m), 1.0))


def linearise_lugre(
    limit_n: float,
    speed_m_s: float,
    bristle_stiffness_n_per_m: float = BRISTLE_STIFFNESS_N_PER_M,
    bristle_damping_n_s_per_m: float = BRISTLE_DAMPING_N_S_PER_M,
) -> Lti:
    """Return F/Fc = (1 + s s1(v)/s0) / (1 + s T), s1(v) = s1 / (1 + s1 |v|/(4 Fc)): Dahl's pole and a zero.

    Parameters
    ----------
    limit_n, speed_m_s, bristle_stiffness_n_per_m
        As in `linearise_dahl`.
    bristle_damping_n_s_per_m
        s1 in N s/m, at least 0.

    Raises
    ------
    FrictionloopError
        For a value out of range.
    """
    relaxation_s = _relaxation_s(limit_n, speed_m_s, bristle_stiffness_n_per_m)
    s1 = number("bristle_damping_n_s_per_m", bristle_damping_n_s_per_m, "N s/m", 0.0)
    effective = s1 / (1.0 + s1 * abs(speed_m_s) / (4.0 * limit_n))
    return Lti((effective / bristle_stiffness_n_per_m, 1.0), (relaxation_s, 1.0))


def linearise_slider() -> Lti:
    """Return F/Fc = 1: a slider that slides is at its limit."""
    return Lti((1.0,), (1.0,))


def _relaxation_s(limit_n: float, speed_m_s: float, bristle_stiffness_n_per_m: float) -> float:
    number("limit_n", limit_n, "N", ABOVE_0)
    number("bristle_stiffness_n_per_m", bristle_stiffness_n_per_m, "N/m", ABOVE_0)
    if not (math.isfinite(speed_m_s) and speed_m_s != 0.0):
        raise FrictionloopError(f"speed_m_s = {speed_m_s:g} m/s: must be finite and not 0")
    return limit_n / (bristle_stiffness_n_per_m * abs(speed_m_s))
