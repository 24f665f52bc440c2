"""Elastoplastic Coulomb contact in series with the skin: a spring that sticks until the limit, then slides at it."""

from __future__ import annotations

from frictionloop.physics.contact import ContactCoefficients, ContactState, follow_step, free_slide_step
from frictionloop.quantities.arithmetic import fma, step


@step
def slider_step(
    state: ContactState, limit_n: float, speed_m_s: float, coefficients: ContactCoefficients
) -> tuple[ContactState, float]:
    """F = s0 z, |F| <= Fc, z' = v while it sticks (return mapping): the state after a step and its mean force in N.

    A trial step that sticks is solved together with the skin; what exceeds the limit slides. ``limit_n`` Fc and
    ``speed_m_s`` w are those of the middle of the step; without a limit (Fc <= 0) there is no force.
    """
    lag, lag_speed, bristle, last = state
    dt, two_per_dt, inertia, elastic, coupling, stuck, stiffness, per_stiffness, _, _ = coefficients
    middle = max(limit_n, 0.0) * per_stiffness
    # A rising limit is a line through the middle, or a tip that comes to stick would stay half a step behind. A falling
    # one is not: a limit that jumps down would be taken too far.
    half_rise = max(0.5 * (middle - last), 0.0)
    first, final = middle - half_rise, middle + half_rise
    z = min(max(bristle, -first), first)
    free = free_slide_step(lag, lag_speed, speed_m_s, dt, inertia, elastic)
    trial = fma(-coupling, z, free) * stuck
    after = min(max(z + trial, -final), final)
    # Sliding: the mean of the limit, less what is missing before the bristle meets it.
    sign = 1.0 if trial > 0.0 else -1.0
    gap = fma(sign, first, -z)
    sliding = fma(sign, middle, -0.5 * gap * (gap / fma(-2.0 * sign, half_rise, trial)))
    mean = fma(0.5, trial, z) if after == z + trial else sliding
    slid = fma(-coupling, mean, free)
    lag, lag_speed = follow_step(lag, lag_speed, fma(dt, speed_m_s, -slid), two_per_dt)
    return ContactState(lag, lag_speed, after, middle), stiffness * mean
