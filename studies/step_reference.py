"""What step times are counted against: the skin on the way up, the drive of the plate on the way down, in closed form.

The skin's spring pulls by k v. The plate's envelope under full drive is a(t) = a_max + (a1 - a_max) e^(-wc t). A
reference, not a bound: the skin's damper pulls besides its spring, and the force passes 10 % when the amplitude is
long past it. What no drive gets past is in `time_optimal`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from frictionloop.parameters import Skin, Strokes, System
from frictionloop.physics.friction import amplitude_for

SHARE_10, SHARE_63, SHARE_90 = 0.1, 0.632, 0.9
"""Shares of a step whose passages are timed, as in `loop.step_times`."""


class StepTimes(NamedTuple):
    """Times of the steps 0.35 to 0.75 N and back, in s, of shape (fingers,); NaN where one has not got the level."""

    rise_63_s: np.ndarray
    rise_10_90_s: np.ndarray
    fall_63_s: np.ndarray
    fall_10_90_s: np.ndarray


def skin_time_s(way_n: float, skin: Skin, speed_mm_s: float) -> float:
    """Return way/(k v), the time in which stuck skin pulls so much harder."""
    return way_n / (skin.stiffness_n_m * 1e-3 * speed_mm_s)


def drive_time_s(from_um: float, to_um: float, max_um: float, cutoff_hz: float) -> float:
    """Return ln((a_max - a1)/(a_max - a2))/(2 pi f) in s, the time of a rise under full drive; NaN if it cannot."""
    if not from_um <= to_um < max_um:
        return math.nan
    return float(np.log((max_um - from_um) / (max_um - to_um)) / (2.0 * np.pi * cutoff_hz))


def reference_times(systems: Sequence[System], levels_n: tuple[float, float]) -> StepTimes:
    """Return the times of skin and drive for fingers of kind "skin" whose law of friction is that of `undisturbed`.

    A fall to 63 % begins ``controller.delay_s`` after the step, which is in the time.
    """
    return StepTimes(*np.reshape([_of_one(each, *levels_n) for each in systems], (len(systems), 4)).T)


def _of_one(system: System, low_n: float, high_n: float) -> tuple[float, float, float, float]:
    step, skin, plate = high_n - low_n, system.finger, system.plate
    assert isinstance(skin, Skin) and isinstance(system.motion, Strokes)

    def fall_s(start: float, stop: float) -> float:
        begins, ends = amplitude_for(np.array([high_n - start * step, high_n - stop * step]), system.friction).tolist()
        return drive_time_s(begins, ends, plate.max_amplitude_um, plate.cutoff_hz)

    given = skin, system.motion.speed_mm_s
    return (
        skin_time_s(SHARE_63 * step, *given),
        skin_time_s((SHARE_90 - SHARE_10) * step, *given),
        system.controller.delay_s + fall_s(0.0, SHARE_63),
        fall_s(SHARE_10, SHARE_90),
    )
