"""A system made ready for a preview: the effect as its set-point, a stroke as its motion, open loop and closed."""

from __future__ import annotations

import math
import os
from typing import Any

from frictionloop.loop.reference_runs import OPENED
from frictionloop.parameters import Skin, Strokes, System, check_system
from frictionloop.parameters.timing import Model
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.files import find
from frictionloop.rendering.source import EffectSource

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
        raise must_be("controller.kind", "lookup", "a law that closes the loop")
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
