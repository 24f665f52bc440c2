"""A system made ready for a preview, what its effect asks for along a stroke, and whether any of that can be felt."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictionloop.loop.companion_runs import OPENED
from frictionloop.parameters import Skin, Strokes, System, check_system
from frictionloop.parameters.controller import Model
from frictionloop.perception.detection_thresholds import HIGHEST_HZ
from frictionloop.preview.pattern_measures import edges_mm
from frictionloop.quantities import Array, FrictionloopError, must_be
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.effect_player import program_of
from frictionloop.rendering.effect_setpoint import EffectSource
from frictionloop.rendering.effect_toml import find
from frictionloop.rendering.library import STARTED_S, longest_s

CYCLES = 2.0
"""Strokes there and back that are simulated (assumed: each place is passed four times)."""


def prepared(effect: Effect | str, system: System, stroke: Strokes | float | None) -> System:
    """Return the system with an effect as its set-point and a stroke as its motion."""
    check_system(system)
    if not isinstance(system.motion, Strokes):
        raise FrictionloopError('motion.kind: must be "strokes"')
    if not isinstance(effect, (Effect, str, os.PathLike)):
        raise must_be("effect", effect, "an effect, a name or a TOML file")
    effect = effect if isinstance(effect, Effect) else find(effect)
    kept = system.setpoint if isinstance(system.setpoint, EffectSource) else EffectSource()
    changes: dict[str, Any] = {"setpoint": kept.model_copy(update={"effect": effect})}
    if isinstance(stroke, Strokes):
        changes["motion"] = stroke
    elif stroke is not None and not isinstance(stroke, (int, float)):
        raise must_be("stroke", stroke, "a speed in mm/s or Strokes")
    elif stroke is not None:
        changes["motion.speed_mm_s"] = stroke
        changes["motion.reversal_s"] = min(system.motion.reversal_s, 0.5 * system.motion.stroke_mm / max(stroke, 1e-9))
    return system.evolve(changes)


def both(system: System, table: Model | None = None) -> dict[str, System]:
    """Return the system with the lookup alone, of its own table or another, and with its own law, by law."""
    if system.controller.kind == "lookup":
        raise must_be("controller.kind", "lookup", "a closed-loop law")
    if table is not None and not isinstance(table, Model):
        raise must_be("table", table, "a Model, as controller.model")
    own = {} if table is None else {"controller.model": table}
    return {"lookup": system.evolve({**OPENED, **own}), system.controller.kind: system}


def skin_n_mm(system: System) -> float:
    """Return the stiffness of the skin, N/mm; inf for a rigid finger."""
    return 1e-3 * system.finger.stiffness_n_m if isinstance(system.finger, Skin) else math.inf


def duration_s(system: System) -> float:
    """Return how long a preview takes, a whole number of control periods."""
    motion, rate = system.motion, system.controller.rate_hz
    assert isinstance(motion, Strokes)
    return math.ceil(CYCLES * motion.cycle_s * rate) / rate


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
        ways.append(np.broadcast_to(np.asarray(source.effect.force_of(touch), float), fine.shape))
    raw = np.array(ways)
    held = np.clip(raw, model.floor_n, model.nominal_n)
    middle = held[:, 20::40]
    slope = np.abs(np.diff(held, axis=1)).max() / (fine[1] - fine[0])
    error = program_of(source.effect, source.track, system.touch.load.length_mm).error_n
    place = 0.5 * (edges[1:] + edges[:-1])
    beyond, every = np.abs(raw - held), np.concatenate([raw.ravel(), _while_waves_play(source, motion, fine)])
    ends = float(every.min()), float(every.max())
    share, most = float(np.mean(beyond > 0)), float(beyond.max())
    return StrokeForces(place, middle[0], middle[1], share, most, float(slope), error, *ends)


def _while_waves_play(source: EffectSource, motion: Strokes, fine: Array) -> Array:
    """Return forces along the stroke at times since a wave began; none for an effect without waves."""
    longest = longest_s(source.effect)
    if longest == 0.0:
        return np.zeros(0)
    time_s = np.linspace(0.0, longest, TIMES)
    first, length = fine[0], fine[-1] - fine[0]
    place = first + np.mod(motion.speed_mm_s * time_s, length)
    touch = source.track.touch(place, motion.speed_mm_s, motion.load_n, time_s)
    return np.broadcast_to(np.asarray(source.effect.force_of(touch), float), time_s.shape)


def playable_forces(system: System) -> StrokeForces:
    """Return what the effect of a system asks for, refusing one of which nothing can be given or felt."""
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
