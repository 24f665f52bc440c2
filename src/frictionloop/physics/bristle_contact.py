"""The contact of skin and glass: a bristle whose length is how far the tip slides while friction follows its limit.

The skin is a lateral spring, damper and mass between bone and contact, m x'' + c x' + k x = F. The bone moves over the
glass with speed w, the tip lags behind it by x, and so slides with v = w - x'. A step takes the friction limit and the
bone's speed in the middle of the step (or their means over it) and returns the mean force over the step.
docs/model.md has the equations.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from frictionloop.parameters import Skin
from frictionloop.quantities import Lti
from frictionloop.quantities.scalar_math import fma, step

STRONG_N = 1.0
"""Largest friction limit whose ringing with the tip a step damps (assumed: that of a strong finger)."""
TINY = 1e-300
"""Keeps 0/0 out where nothing moves and nothing rubs."""


class ContactState(NamedTuple):
    """Where tip and contact are; all zero for a finger off the glass at rest."""

    lag_m: float
    """x, of the tip behind the bone."""
    lag_speed_m_s: float
    """x'."""
    force_n: float
    """F of the bristle."""
    age_s: float = 0.0
    """Of the contact (physics/friction_limit)."""


class ContactCoefficients(NamedTuple):
    """Constants of a step, with A = 1 / (m/(u dt) + c + k dt/2), the skin's mean speed per newton of mean force."""

    dt: float
    per_step: float
    """1/(u dt)."""
    kept: float
    """1/u - 1, of the speed of the lag."""
    inertia: float
    """m A/u."""
    elastic: float
    """dt k A."""
    yielding: float
    """dt A: how far the tip yields in a step, m/N."""
    length: float
    """z in m."""
    beyond: float
    """z/y: how far a force may be beyond a limit that fell, N; from farther it snaps back within a step."""


def contact_coefficients(skin: Skin, dt: float) -> ContactCoefficients:
    """Return the constants of `bristle_step` for steps of ``dt`` s; any is stable (docs/model.md: how accurate).

    The mean speed of the lag is x' + u dx', u = 1/2: the midpoint rule. It would let a tip that sticks ring for ever on
    a bristle that is stiffer than a step resolves, dt^2 F/(4 m z) > 1 with F = `STRONG_N`; there u rises to 1 at z = 0.
    """
    k, c, m, z = skin.stiffness_n_m, skin.damping_n_s_m, skin.mass_kg, 1e-6 * skin.slip_length_um
    resolved = dt * dt * STRONG_N / (4.0 * m)
    u = max(0.5, 1.0 - 0.5 * z / resolved)
    yielding = 1.0 / (m / (u * dt) + c + k * dt / 2.0)
    return ContactCoefficients(
        dt=dt,
        per_step=1.0 / (u * dt),
        kept=1.0 / u - 1.0,
        inertia=m * yielding / u,
        elastic=dt * k * yielding,
        yielding=dt * yielding,
        length=z,
        beyond=z / (dt * yielding),
    )


@step
def bristle_step(
    state: ContactState, limit_n: float, speed_m_s: float, coefficients: ContactCoefficients
) -> tuple[ContactState, float]:
    """dF/dt = (v Fc - |v| F)/z (Dahl 1968, with a length): the state after a step and its mean force in N.

        z dF = s Fc - |s| (F + t dF),   s = free - y (F + t dF),   t = (3 z + |s|)/(6 z + |s|)

    s is how far the tip slides, y how far it yields to a newton; t is that of the force at the start. In the direction
    of s this is a quadratic in dF. With z = 0 the force is free/y while that is within the limit, else the limit.
    ``limit_n`` Fc and ``speed_m_s`` w are those of the middle of the step; without a limit (Fc <= 0) there is no force.
    """
    lag, lag_speed, before, age_s = state
    dt, per_step, kept, inertia, elastic, yielding, length, beyond = coefficients
    limit = max(limit_n, 0.0)
    most = limit + beyond if limit > 0.0 else 0.0
    force = min(max(before, -most), most)
    pulled = fma(elastic, lag, -(inertia * lag_speed))
    free = fma(dt, speed_m_s, pulled)
    slip = fma(-yielding, force, free)
    way = abs(slip)
    sign = 1.0 if slip >= 0.0 else -1.0
    gap = fma(-sign, force, limit)
    three, six = fma(3.0, length, way), fma(6.0, length, way)
    # share^2 y t^2 - share b + way gap = 0, dF = share six; the smaller root, without cancellation.
    pull, product = yielding * three, 2.0 * way * gap
    b = fma(three, way, fma(pull, gap, length * six))
    root = math.sqrt(max(fma(b, b, -2.0 * pull * three * product), 0.0))
    share = product / max(b + root, TINY)
    mean = fma(sign * three, share, force)
    moved = fma(yielding, mean, -pulled)
    speed = fma(per_step, moved, -(kept * lag_speed))
    return ContactState(lag + moved, speed, fma(sign * six, share, force), age_s), mean


def linearise_slip(skin: Skin, force_n: float, speed_m_s: float) -> Lti:
    """Return friction limit to force F for small signals at steady sliding with speed v: 1/(1 + s z/|v|), N/N.

    There v Fc = |v| F, so the force does not feel small changes of speed: the skin drops out, and holds again only
    where the force would have to rise faster than the skin allows (docs/model.md).
    """
    if skin.slip_length_um == 0.0:
        return Lti((1.0,), (1.0,))
    return Lti((1.0,), (1e-6 * skin.slip_length_um / abs(speed_m_s), 1.0))
