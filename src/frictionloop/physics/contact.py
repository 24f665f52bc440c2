"""What the three laws of the contact share: state of tip and bristle, the skin they pull on, constants of a step.

A step takes the friction limit and the bone's speed in the middle of the step (or their means over it) and returns the
mean force over the step. Inside, forces are counted in the deflection of the bristle, F/s0, and speeds in the way
covered in a step, so that a law needs one division per pass. docs/contact.md derives them.

The skin is a lateral spring, damper and mass between bone and contact, m x'' + c x' + k x = F. The bone moves over the
glass with speed w, the tip lags behind it by x, and so slides with v = w - x'. Over a step the skin follows the
implicit midpoint rule, which keeps the books of energy exactly at any step: with F the mean force of the step, the
work F (x1 - x0) is what spring and mass gain plus what the damper takes.
"""

from __future__ import annotations

from typing import NamedTuple

from frictionloop.parameters import Skin
from frictionloop.quantities import Lti
from frictionloop.quantities.arithmetic import fma, step

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
    """Constants of a step.

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


@step
def free_slide_step(
    lag_m: float, lag_speed_m_s: float, speed_m_s: float, dt: float, inertia: float, elastic: float
) -> float:
    """dt w - (2 m A x' - dt k A x): how far the tip slides in a step without force, A = 1 / (2 m/dt + c + k dt/2)."""
    return fma(dt, speed_m_s, fma(elastic, lag_m, -(inertia * lag_speed_m_s)))


@step
def follow_step(lag_m: float, lag_speed_m_s: float, moved_m: float, two_per_dt: float) -> tuple[float, float]:
    """x + dx, 2 dx/dt - x': lag and its speed after a step in which the lag changed by dx."""
    return lag_m + moved_m, fma(two_per_dt, moved_m, -lag_speed_m_s)


def contact_coefficients(skin: Skin, dt: float) -> ContactCoefficients:
    """Return the constants of `dahl_step`, `lugre_step` and `slider_step` for steps of ``dt`` s.

    Any length is stable; docs/contact.md says how accurate.
    """
    k, c, m = skin.stiffness_n_m, skin.damping_n_s_m, skin.mass_kg
    s0, s1 = skin.bristle_stiffness_n_m, skin.bristle_damping_n_s_m
    yielding = 1.0 / (2.0 * m / dt + c + k * dt / 2.0)
    coupling, damping = dt * s0 * yielding, s1 / (s0 * dt)
    return ContactCoefficients(
        dt=dt,
        two_per_dt=2.0 / dt,
        inertia=2.0 * m * yielding,
        elastic=dt * k * yielding,
        coupling=coupling,
        stuck=1.0 / (1.0 + coupling / 2.0),
        bristle=s0,
        per_bristle=1.0 / s0,
        damping=damping,
        guard=damping,
    )


def linearise_slip(skin: Skin, force_n: float, speed_m_s: float) -> Lti:
    """Return friction limit to force F for small signals at steady sliding with speed v, N/N.

        slider 1,   Dahl 1 / (1 + s T),   LuGre (1 + s s1(v)/s0) / (1 + s T),
        T = F/(s0 |v|),   s1(v) = s1 / (1 + s1 |v|/(4 F))

    There v (1 - s0 z sign(v)/Fc) = 0, so the force does not feel small changes of speed: the skin drops out, and holds
    again only where the force would have to rise faster than the skin allows (docs/contact.md).
    """
    if skin.contact == "slider":
        return Lti((1.0,), (1.0,))
    s0, s1 = skin.bristle_stiffness_n_m, skin.bristle_damping_n_s_m
    relaxation_s = force_n / (s0 * abs(speed_m_s))
    if skin.contact == "dahl":
        return Lti((1.0,), (relaxation_s, 1.0))
    return Lti((s1 / (1.0 + s1 * abs(speed_m_s) / (4.0 * force_n)) / s0, 1.0), (relaxation_s, 1.0))
