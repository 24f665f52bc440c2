"""Position, speed and load once per control period: a position sensor with a tracker, the sum of four load cells."""

from __future__ import annotations

import math
from typing import NamedTuple

from frictionloop.parameters.motion import Sliding, Strokes
from frictionloop.parameters.touch import PositionSensor, Touch
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.arithmetic import fma, step

POSITION_STREAM, LOAD_STREAM = 22, 23
"""Streams of the counter-based noise of the position sensor and of the measured load."""


class TouchState(NamedTuple):
    """Tracked position in m and speed in m/s."""

    position: float
    speed: float


class TouchCoefficients(NamedTuple):
    """Coefficients of `touch_step`."""

    position_noise_m: float
    load_noise_n: float
    touch_n: float
    least_speed_m_s: float
    dt: float
    position_gain: float
    speed_gain: float
    """Gain of the tracker's speed, over dt, in 1/s."""


@step
def touch_step(  # type: ignore[no-untyped-def]
    state: TouchState, position_m: float, load_n: float, z_position: float, z_load: float, coefficients
) -> tuple[TouchState, tuple[float, float, float, float]]:
    """Measure position (m), speed (m/s), load (N) and valid (1 or 0), the last four of a `Measurement`.

    The measured load is the sum of four cells, each with noise of its own: N + 2 sigma z. The tracker predicts x + v dt
    and corrects both by its error e: x += alpha e, v += beta e/dt. Without touch it waits at the last sample.
    """
    tracked, speed = state
    position_noise, load_noise, touch_n, least_speed, dt, position_gain, speed_gain = coefficients
    load = fma(load_noise, z_load, load_n)
    position = fma(position_noise, z_position, position_m)
    predicted = fma(speed, dt, tracked)
    error = position - predicted
    touches = load >= touch_n
    tracked = fma(position_gain, error, predicted) if touches else position
    speed = fma(speed_gain, error, speed) if touches else 0.0
    valid = 1.0 if touches & (abs(speed) >= least_speed) else 0.0
    return TouchState(tracked, speed), (position, speed, load, valid)


def touch_coefficients(touch: Touch, dt: float) -> TouchCoefficients:
    """Return the coefficients of `touch_step` for a control period in s: both poles of the tracker at e^(-w dt)."""
    pole = math.exp(-2.0 * math.pi * touch.position.tracking_hz * dt)
    return TouchCoefficients(
        position_noise_m=1e-6 * touch.position.noise_um,
        load_noise_n=2.0 * touch.load.noise_n,
        touch_n=touch.load.touch_n,
        least_speed_m_s=1e-3 * touch.load.least_speed_mm_s,
        dt=dt,
        position_gain=1.0 - pole * pole,
        speed_gain=(1.0 - pole) ** 2 / dt,
    )


def speed_noise_m_s(sensor: PositionSensor, dt: float) -> float:
    """Return the standard deviation of the tracked speed, (sigma/dt) sqrt(2 beta^2 / (alpha (4 - 2 alpha - beta))).

    Source: variance reduction of the alpha-beta filter, Kalata, IEEE Trans. AES 20 (1984) 174-182 (quoted from memory;
    tested against the covariance of the filter).
    """
    pole = math.exp(-2.0 * math.pi * sensor.tracking_hz * dt)
    alpha, beta = 1.0 - pole * pole, (1.0 - pole) ** 2
    return 1e-6 * sensor.noise_um / dt * beta * math.sqrt(2.0 / (alpha * (4.0 - 2.0 * alpha - beta)))


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
            f"motion.speed_mm_s = {motion.speed_mm_s:g} mm/s: the position sensor follows up to "
            f"touch.position.fastest_mm_s = {touch.position.fastest_mm_s:g} mm/s"
        )
    if motion.stroke_mm > touch.load.length_mm:
        raise FrictionloopError(
            f"motion.stroke_mm = {motion.stroke_mm:g} mm: the plate between the load cells is "
            f"touch.load.length_mm = {touch.load.length_mm:g} mm long"
        )
