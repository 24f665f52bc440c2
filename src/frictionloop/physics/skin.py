"""The fingertip's skin: a lateral spring, damper and mass between bone and contact, m x'' + c x' + k x = F.

The bone moves over the glass with speed w, the tip lags behind it by x, and so slides with v = w - x'. Over a step the
skin follows the implicit midpoint rule, which keeps the books of energy exactly at any step: with F the mean force of
the step, the work F (x1 - x0) is what spring and mass gain plus what the damper takes.
"""

from __future__ import annotations

from frictionloop.parameters import Skin
from frictionloop.quantities.arithmetic import fma, step

_SKIN = Skin()
SKIN_STIFFNESS_N_PER_M, SKIN_DAMPING_N_S_PER_M, SKIN_MASS_KG = _SKIN.stiffness_n_m, _SKIN.damping_n_s_m, _SKIN.mass_kg
"""k, c and m where none are given; sources in parameters/finger."""


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
