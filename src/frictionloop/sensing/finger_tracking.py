"""Position, speed and load once per control period: an alpha-beta filter of the position, four load cells' sum."""

from __future__ import annotations

import math
from typing import NamedTuple

from frictionloop.parameters import System
from frictionloop.parameters.motion import Sliding, Strokes, Touch
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.scalar_math import fma, step

CREEP_M_S = 2.0**-28
"""Least speed that is told, as one that turns back by less than a turn: the last place of the firmware's."""
POSITION_STREAM, LOAD_STREAM = 22, 23
"""Streams of the counter-based noise of the position sensor and of the measured load."""


class TouchState(NamedTuple):
    """Tracked position in m and speed in m/s, running mean of the load in N, and how the skin is stretched."""

    position: float
    speed: float
    mean_load: float = 0.0
    missing: float = 0.0
    """Way in m along the direction until the skin is stretched, 0 to twice ``developed_m``."""
    back: float = 0.0
    """Way in m back from the farthest place."""
    direction: float = 1.0
    """Of the motion since its last turn, 1 or -1."""
    mean_speed: float = 0.0
    """Running mean of the speed's size in m/s."""


class TouchCoefficients(NamedTuple):
    """Coefficients of `touch_step`."""

    position_noise_m: float
    position_step_m: float
    """Step that a position is rounded to; 0: none."""
    position_per_m: float
    """Steps per m."""
    load_noise_n: float
    touch_n: float
    least_speed_m_s: float
    dt: float
    position_gain: float
    speed_gain: float
    """Gain of the filter's speed, over dt, in 1/s."""
    touch_share: float
    mean_gain: float
    developed_m: float
    turn_m: float
    speed_share: float


@step
def touch_step(  # type: ignore[no-untyped-def]
    state: TouchState, position_m: float, load_n: float, z_position: float, z_load: float, coefficients
) -> tuple[TouchState, tuple[float, float, float, float]]:
    """Measure position (m), speed (m/s), load (N) and valid (1 or 0), the last four of a `Measurement`.

    The position has noise and is rounded to a step, q floor((x + sigma z)/q + 1/2). The measured load is the sum of
    four cells, each with noise of its own: N + 2 sigma z. The filter predicts x + v dt and corrects both by its error
    e: x += alpha e, v += beta e/dt. Without touch it waits at the last sample.

    A reading is valid while the finger slides under most of its usual load on a skin that is stretched: before, force
    below the set-point is no error to act on. The skin is a play of ``developed_m`` on both sides: a landing goes half
    of it, a turn all of it, and a finger that trembles back goes that way again. It has turned once it is back by
    ``turn_m``; until then, in a pause and in the air, the direction stays, and the speed told does not contradict it.
    A finger that presses less than usual still touches: its speed and usual load go on.
    """
    tracked, speed, mean, missing, back, direction, usual = state
    (
        noise_m, step_m, per_m, load_noise, touch_n, least_speed, dt,
        position_gain, speed_gain, share, gain, developed, turn, speed_share,
    ) = coefficients  # fmt: skip
    load = fma(load_noise, z_load, load_n)
    position = fma(noise_m, z_position, position_m)
    position = step_m * math.floor(fma(per_m, position, 0.5)) if step_m > 0.0 else position
    predicted = fma(speed, dt, tracked)
    error = position - predicted
    touches, presses = load >= touch_n, load >= max(touch_n, share * mean)
    mean = fma(gain, load - mean, mean) if touches else mean
    tracked = fma(position_gain, error, predicted) if touches else position
    speed = fma(speed_gain, error, speed) if touches else 0.0
    ahead = direction * speed * dt
    missing = min(max(missing - (ahead if presses else 0.0), 0.0), 2.0 * developed) if touches else developed
    back = max(back - ahead, 0.0) if touches else 0.0
    turns = back > turn
    missing, back = 2.0 * developed - missing if turns else missing, 0.0 if turns else back
    direction = -direction if turns else direction
    usual = fma(gain, abs(speed) - usual, usual) if touches else usual
    slides = presses & (abs(speed) >= max(least_speed, speed_share * usual)) & (missing <= 0.0)
    told = direction * max(direction * speed, CREEP_M_S)
    return TouchState(tracked, speed, mean, missing, back, direction, usual), (
        position,
        told,
        load,
        1.0 if slides else 0.0,
    )


def touch_coefficients(touch: Touch, dt: float) -> TouchCoefficients:
    """Return the coefficients of `touch_step` for a control period in s: both poles of the filter at e^(-w dt)."""
    pole = math.exp(-2.0 * math.pi * touch.position.tracking_hz * dt)
    return TouchCoefficients(
        position_noise_m=1e-6 * touch.position.noise_um,
        position_step_m=1e-6 * touch.position.resolution_um,
        position_per_m=1e6 / touch.position.resolution_um if touch.position.resolution_um else 0.0,
        load_noise_n=2.0 * touch.load.noise_n,
        touch_n=touch.load.touch_n,
        least_speed_m_s=1e-3 * touch.load.least_speed_mm_s,
        dt=dt,
        position_gain=1.0 - pole * pole,
        speed_gain=(1.0 - pole) ** 2 / dt,
        touch_share=touch.load.touch_share,
        mean_gain=-math.expm1(-dt / touch.load.mean_s),
        developed_m=1e-3 * touch.load.developed_mm,
        turn_m=1e-3 * touch.load.turn_mm,
        speed_share=touch.load.speed_share,
    )


def board_touch(system: System) -> TouchCoefficients:
    """Return the coefficients of a board, whose readings have their own noise; what always slides is always valid."""
    given = touch_coefficients(system.touch, 1.0 / system.controller.rate_hz)._replace(
        position_noise_m=0.0, position_step_m=0.0, position_per_m=0.0, load_noise_n=0.0
    )
    if isinstance(system.motion, Strokes):
        return given
    return given._replace(touch_n=0.0, touch_share=0.0, least_speed_m_s=0.0, speed_share=0.0, developed_m=0.0)


def check_follows(motion: Sliding | Strokes, touch: Touch) -> None:
    """Refuse strokes that are faster than the position sensor or longer than the plate.

    Raises
    ------
    FrictionloopError
        Naming the parameter of the motion, its value, and what the sensor accepts.
    """
    if isinstance(motion, Sliding):
        return
    if motion.speed_mm_s > touch.position.fastest_mm_s:
        raise FrictionloopError(
            f"motion.speed_mm_s = {motion.speed_mm_s:g} mm/s: above "
            f"touch.position.fastest_mm_s = {touch.position.fastest_mm_s:g}"
        )
    if motion.stroke_mm > touch.load.length_mm:
        raise FrictionloopError(
            f"motion.stroke_mm = {motion.stroke_mm:g} mm: above touch.load.length_mm = {touch.load.length_mm:g}"
        )
