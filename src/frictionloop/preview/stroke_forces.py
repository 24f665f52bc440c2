"""What an effect asks for along a stroke, and whether any of it can be given and felt."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictionloop.parameters import Strokes, System
from frictionloop.perception.thresholds import HIGHEST_HZ
from frictionloop.preview.measures import edges_mm
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.checks import Array
from frictionloop.rendering.compiling import program_of
from frictionloop.rendering.effect_summary import STARTED_S, longest_s
from frictionloop.rendering.source import EffectSource

TIMES = 4096
"""Times at which a wave is looked at (assumed: a wave of a second every 0.25 ms)."""


@dataclass(frozen=True)
class StrokeForces:
    """What an effect asks for along a stroke, within the band that the controller believes in."""

    place_mm: Array
    forth_n: Array
    back_n: Array
    share_clamped: float
    clamped_n: float
    steepest_n_mm: float
    table_error_n: float
    least_n: float
    """Least force before the band, also while waves of it play."""
    largest_n: float
    """Largest force before the band."""


def stroke_forces(system: System) -> StrokeForces:
    """Return what the effect of a system asks for along its stroke."""
    source, motion, model = system.setpoint, system.motion, system.controller.model
    assert isinstance(source, EffectSource)
    assert isinstance(motion, Strokes)
    edges = edges_mm(motion)
    fine = np.linspace(edges[0], edges[-1], 40 * (edges.size - 1) + 1)
    ways = []
    for way in (1.0, -1.0):
        touch = source.track.touch(fine, way * motion.speed_mm_s, motion.load_n, STARTED_S)
        ways.append(np.broadcast_to(np.asarray(source.effect.asked(touch), float), fine.shape))
    raw = np.array(ways)
    held = np.clip(raw, model.floor_n, model.nominal_n)
    middle = held[:, 20::40]
    slope = np.abs(np.diff(held, axis=1)).max() / (fine[1] - fine[0])
    error = program_of(source.effect, source.track, system.touch.load.length_mm).error_n
    place = 0.5 * (edges[1:] + edges[:-1])
    beyond, every = np.abs(raw - held), np.concatenate([raw.ravel(), _while_waves_play(system, fine)])
    ends = float(every.min()), float(every.max())
    share, most = float(np.mean(beyond > 0)), float(beyond.max())
    return StrokeForces(place, middle[0], middle[1], share, most, float(slope), error, *ends)


def _while_waves_play(system: System, fine: Array) -> Array:
    """Return forces along the stroke at times since a wave began; none for an effect without waves."""
    source, motion = system.setpoint, system.motion
    assert isinstance(source, EffectSource)
    assert isinstance(motion, Strokes)
    longest = longest_s(source.effect)
    if longest == 0.0:
        return np.zeros(0)
    time_s = np.linspace(0.0, longest, TIMES)
    first, length = fine[0], fine[-1] - fine[0]
    place = first + np.mod(motion.speed_mm_s * time_s, length)
    touch = source.track.touch(place, motion.speed_mm_s, motion.load_n, time_s)
    return np.broadcast_to(np.asarray(source.effect.asked(touch), float), time_s.shape)


def playable_forces(system: System) -> StrokeForces:
    """Return what the effect of a system asks for, refusing one of which nothing can be given or felt.

    Raises
    ------
    FrictionloopError
        For forces that are out of reach everywhere, and for a period that is too short to be felt or played at the
        stroke's speed.
    """
    source, motion, model = system.setpoint, system.motion, system.controller.model
    assert isinstance(source, EffectSource)
    assert isinstance(motion, Strokes)
    asked = stroke_forces(system)
    if asked.share_clamped == 1.0 and (asked.largest_n < model.floor_n or asked.least_n > model.nominal_n):
        raise FrictionloopError(
            f"effect = {asked.least_n:.3g} to {asked.largest_n:.3g} N: must have some of the controller's band, "
            f"{model.floor_n:.3g} to {model.nominal_n:.3g} N",
            "EFFECT-OUT",
        )
    period, fastest = source.effect.period_mm, min(HIGHEST_HZ, 0.5 * system.controller.rate_hz)
    if period and motion.speed_mm_s / period > fastest:
        raise FrictionloopError(
            f"effect: period {period:g} mm is {motion.speed_mm_s / period:.4g} Hz at {motion.speed_mm_s:g} mm/s; must "
            f"be at least {motion.speed_mm_s / fastest:.3g} mm"
        )
    return asked
