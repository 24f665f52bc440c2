"""What no control law gets past on a step: the skin on the way up, the drive of the plate on the way down.

The skin pulls no faster than k_eff v, the skin in series with the bristle of the contact (`Skin.stuck_stiffness_n_m`).
The plate's envelope under full drive is a(t) = a_max + (a1 - a_max) e^(-wc t), and the force falls no faster than the
friction limit under it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from frictionloop.design.operating import law_at
from frictionloop.design.tournament.protocol import STEP_LEVELS_N
from frictionloop.parameters import Skin, Strokes, System
from frictionloop.physics.friction import amplitude_for

SHARE_63 = 0.632


class StepLimits(NamedTuple):
    """Shortest times of the steps 0.35 to 0.75 N and back, in s; NaN where a finger has not got the level."""

    rise_63_s: float
    rise_10_90_s: float
    fall_63_s: float
    fall_10_90_s: float


def skin_time_s(way_n: float, skin: Skin, speed_mm_s: float) -> float:
    """Return way/(k_eff v), the time in which stuck skin pulls so much harder."""
    return way_n / (skin.stuck_stiffness_n_m * 1e-3 * speed_mm_s)


def drive_time_s(from_um: float, to_um: float, max_um: float, cutoff_hz: float) -> float:
    """Return ln((a_max - a1)/(a_max - a2))/(2 pi f) in s, the time of a rise under full drive; NaN if it cannot."""
    if not from_um <= to_um < max_um:
        return math.nan
    return float(np.log((max_um - from_um) / (max_um - to_um)) / (2.0 * np.pi * cutoff_hz))


def step_limits(system: System, finger: Mapping[str, Any], occluded: float = 0.0) -> StepLimits:
    """Return the shortest times of a finger on a bench, at its mean load and so far occluded, without delays.

    Falls to 63 % begin a dead time of the loop after the step, ``controller.delay_s`` at least, which is in the limit.
    """
    own = system.evolve(finger)
    low, high = STEP_LEVELS_N
    step, skin, plate = high - low, own.finger, own.plate
    law = law_at(own, occluded)

    def fall_s(start: float, stop: float) -> float:
        begins, ends = amplitude_for(np.array([high - start * step, high - stop * step]), law).tolist()
        return drive_time_s(begins, ends, plate.max_amplitude_um, plate.cutoff_hz)

    assert isinstance(skin, Skin) and isinstance(own.motion, Strokes)
    given = skin, own.motion.speed_mm_s
    return StepLimits(
        skin_time_s(SHARE_63 * step, *given),
        skin_time_s(0.8 * step, *given),
        own.controller.delay_s + fall_s(0.0, SHARE_63),
        fall_s(0.1, 0.9),
    )
