"""The laws of the contact, each in series with the skin: Dahl's and LuGre's bristles, and a Coulomb slider.

Dahl and LuGre: z' = v - s0 |v| z/Fc. With |v| frozen at a value d/dt this is linear, and a mean deflection
z + theta dz with theta = (3 + q)/(6 + q), q = d/l, l = Fc/s0, relaxes like the Pade approximant (1, 2) of e^-q: third
order, and it damps at any q. Skin, bristle and force are then solved together by one division, and again with |v| of
the solution. Freezing |v| at any value keeps the contact passive: the number of passes is a matter of accuracy alone.
"""

from __future__ import annotations

from frictionloop.physics.contact import LEAST_LIMIT_M, ContactCoefficients, ContactState, follow_step, free_slide_step
from frictionloop.quantities.arithmetic import fma, step


@step
def dahl_step(
    state: ContactState, limit_n: float, speed_m_s: float, coefficients: ContactCoefficients
) -> tuple[ContactState, float]:
    """z' = v (1 - s0 z sign(v)/Fc), F = s0 z (Dahl 1968): the state after a step and its mean force in N.

    ``limit_n`` Fc and ``speed_m_s`` w are those of the middle of the step; without a limit (Fc <= 0) there is no force.
    """
    lag, lag_speed, bristle, _ = state
    dt, two_per_dt, inertia, elastic, coupling, _, stiffness, per_stiffness, _, _ = coefficients
    touches = limit_n > 0.0
    limit = max(limit_n * per_stiffness, LEAST_LIMIT_M)
    z = bristle if touches else 0.0
    free = free_slide_step(lag, lag_speed, speed_m_s, dt, inertia, elastic)
    slid = fma(-coupling, z, free)
    change, mean = 0.0, 0.0
    for _pass in range(2):
        change, mean = dahl_pass(z, limit, abs(slid), free, coupling)
        slid = fma(-coupling, mean, free)
    lag, lag_speed = follow_step(lag, lag_speed, fma(dt, speed_m_s, -slid), two_per_dt)
    return ContactState(lag, lag_speed, z + change if touches else 0.0, limit), stiffness * mean if touches else 0.0


@step
def lugre_step(
    state: ContactState, limit_n: float, speed_m_s: float, coefficients: ContactCoefficients
) -> tuple[ContactState, float]:
    """z' = v - s0 |v| z/Fc, F = s0 z + s1(v) z' (Canudas de Wit 1995): the state after a step and its mean force in N.

    s1(v) = s1 / (1 + s1 |v|/(4 Fc)) stays below 4 Fc/|v|, so the contact is passive also while the limit falls.
    ``limit_n`` Fc and ``speed_m_s`` w are those of the middle of the step; without a limit (Fc <= 0) there is no force.
    """
    lag, lag_speed, bristle, _ = state
    dt, two_per_dt, inertia, elastic, coupling, _, stiffness, per_stiffness, damping, guard = coefficients
    touches = limit_n > 0.0
    limit = max(limit_n * per_stiffness, LEAST_LIMIT_M)
    z = bristle if touches else 0.0
    free = free_slide_step(lag, lag_speed, speed_m_s, dt, inertia, elastic)
    slid = fma(-coupling, z, free)
    change, mean = 0.0, 0.0
    # One pass more than Dahl: the force feels the speed directly.
    for _pass in range(3):
        change, mean = lugre_pass(z, limit, abs(slid), free, coupling, damping, guard)
        slid = fma(-coupling, mean, free)
    lag, lag_speed = follow_step(lag, lag_speed, fma(dt, speed_m_s, -slid), two_per_dt)
    return ContactState(lag, lag_speed, z + change if touches else 0.0, limit), stiffness * mean if touches else 0.0


@step
def lugre_force_step(state: ContactState, limit_n: float, speed_m_s: float, coefficients: ContactCoefficients) -> float:
    """F = s0 z + s1(v) (v - s0 |v| z/Fc) at an instant, as the traces tell it; of the other laws it is s0 z."""
    _, lag_speed, bristle, _ = state
    dt, _, _, _, _, _, stiffness, per_stiffness, damping, guard = coefficients
    slip = speed_m_s - lag_speed
    limit = max(limit_n * per_stiffness, LEAST_LIMIT_M)
    rate = fma(-abs(slip), bristle / limit, slip) * dt
    limited = damping / fma(0.25 * guard * dt, abs(slip) / limit, 1.0)
    return stiffness * fma(limited, rate, bristle) if limit_n > 0.0 else 0.0


@step
def dahl_pass(z: float, limit: float, way: float, free: float, coupling: float) -> tuple[float, float]:
    """dz (1 + theta (q + B)) = free - (q + B) z, q = d/l: change and mean of the deflection for a way d = |v| dt."""
    three, six = fma(3.0, limit, way), fma(6.0, limit, way)
    yielding = fma(coupling, limit, way)
    share = fma(limit, free, -(yielding * z)) / fma(three, yielding, limit * six)
    return six * share, fma(three, share, z)


@step
def lugre_pass(
    z: float, limit: float, way: float, free: float, coupling: float, damping: float, guard: float
) -> tuple[float, float]:
    """dz (1 + theta (q + B) + B G') = free - (q + B) z, G' = G / (1 + G q/4): as `dahl_pass`, the mean is F/s0."""
    three, six = fma(3.0, limit, way), fma(6.0, limit, way)
    yielding = fma(coupling, limit, way)
    four = fma(guard, way, 4.0 * limit)
    viscous = 4.0 * damping * (limit * six)
    denominator = fma(four, fma(three, yielding, limit * six), coupling * limit * viscous)
    share = fma(limit, free, -(yielding * z)) / denominator
    return six * four * share, fma(fma(three, four, viscous), share, z)


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
