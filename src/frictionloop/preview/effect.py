"""The preview of an effect: asked, delivered open loop, delivered closed, side by side."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frictionloop.loop.open_loop import OPENED
from frictionloop.loop.simulate import simulate
from frictionloop.parameters import Skin, Strokes, System, check_system
from frictionloop.parameters.timing import Model
from frictionloop.preview.asked import check
from frictionloop.preview.measures import LEAST_N, Delivered, delivered, over_place
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.checks import Array
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.files import find
from frictionloop.rendering.shapes import Grating
from frictionloop.rendering.source import EffectSource

CYCLES = 2.0
"""Strokes there and back that are simulated (assumed: each place is passed four times)."""


@dataclass(frozen=True)
class Preview:
    """What will be felt of an effect under one finger; forces over ``place_mm``, shape (cells,)."""

    title: str
    """The name of the effect, or its kind."""
    system: System
    """The system with the effect as its set-point and the stroke as its motion."""
    place_mm: Array
    """Middle of each stretch of the stroke."""
    asked_forth_n: Array
    """What the effect asks for on the way forth, at the stroke's speed and load."""
    asked_back_n: Array
    """The same on the way back."""
    low_n: Array
    """Least force within reach of plate and finger; NaN where it never counted."""
    high_n: Array
    """Largest force within reach."""
    table: Model
    """What the lookup table of the open loop is made of."""
    open_loop: Delivered
    """What the lookup alone delivers, with that table."""
    closed_loop: Delivered
    """What the system's control law delivers."""
    share_in_reach: float
    """Share of the scored path on which what is asked for is within reach."""
    share_clamped: float
    """Share of the path on which what is asked for is outside the band that the controller believes in."""
    clamped_n: float
    """By how much at most."""
    steepest_n_mm: float
    """Steepest slope of what is asked for, N/mm."""
    skin_n_mm: float
    """Stiffness of the skin, N/mm: friction rises no faster over place; inf for a rigid finger."""
    position_error_um: float
    """Of the place that the effect is asked at, against the true one, um rms, where a change of place changes it."""
    position_error_n: float
    """What that does to the set-point, N rms."""
    table_error_n: float
    """Largest difference between the effect and the table that it is compiled to."""

    @property
    def speed_mm_s(self) -> float:
        """Speed of the stroke."""
        motion = self.system.motion
        assert isinstance(motion, Strokes)
        return motion.speed_mm_s

    @property
    def effect(self) -> Effect:
        """The effect."""
        assert isinstance(self.system.setpoint, EffectSource)
        return self.system.setpoint.effect

    @property
    def skin_amplitude_n(self) -> float:
        """Largest sine of the effect's period that the skin carries, k L/(2 pi), N; NaN without a period."""
        return self.skin_n_mm * (self.effect.period_mm or math.nan) / (2.0 * math.pi)

    @property
    def amplitude_n(self) -> float:
        """Half of the range of what is asked for along the stroke."""
        both = np.concatenate([self.asked_forth_n, self.asked_back_n])
        return 0.5 * float(both.max() - both.min())

    @property
    def name(self) -> str:
        """What the effect is, in words."""
        effect = self.effect
        what = f"{effect.spacing_mm:g} mm grating" if isinstance(effect, Grating) else Path(self.title).stem
        height = f" of ±{self.amplitude_n:.2g} N" if self.amplitude_n > LEAST_N else ""
        return f"{what}{height} at {self.speed_mm_s:g} mm/s"

    @property
    def sentence(self) -> str:
        """The result in one sentence."""
        here, there = self.open_loop, self.closed_loop
        if not math.isfinite(here.contrast):
            return (
                f"{self.name}: the level errs by {1e3 * abs(here.mean_error_n):.0f} mN open loop with this finger, "
                f"{1e3 * abs(there.mean_error_n):.0f} mN closed"
            )
        return (
            f"{self.name}: {100 * here.contrast:.0f} % of its contrast arrives open loop with this finger, "
            f"{100 * there.contrast:.0f} % closed"
        )


def preview(
    effect: Effect | str,
    system: System,
    stroke: Strokes | float | None = None,
    seed: int = 0,
    *,
    table: Model | None = None,
) -> Preview:
    """Return what a device, a finger's skin and the sense of touch leave of an effect, open and closed loop.

    Parameters
    ----------
    effect : Effect or str
        The effect, the name of one in the library, or a TOML file with one.
    system : System
        Bench, finger and control law.
    stroke : Strokes or float, optional
        How the finger moves, or its speed in mm/s; as the system says if not given.
    seed : int
        Seed of all noise.
    table : Model, optional
        What the open loop's lookup believes: ``fl.bench().controller.model`` is the bench's own table, where a law was
        tuned with other beliefs. That of ``system.controller`` if not given.

    Raises
    ------
    FrictionloopError
        For what is no effect, a stroke that the plate has no room for, or one on which nothing counts.
    """
    shown = prepared(effect, system, stroke)
    asked = check(shown)
    runs = {law: simulate(each, duration_s(shown), seed) for law, each in both(shown, table).items()}
    for run in runs.values():
        if not run["scored"].values.any():
            raise FrictionloopError("stroke: nothing counts on it; a longer stroke or a smaller unscored_n is needed")
    open_loop, closed_loop = (delivered(run, law) for law, run in runs.items())
    closed = runs[shown.controller.kind]
    keep = closed["scored"].values
    names = ("f_r_intended", "limit", "floor", "d", "speed")
    wanted, top, floor, d, way = (closed[name].values[keep] for name in names)
    low, high = (np.fmin(*(over_place(closed, name, way) for way in (1.0, -1.0))) for name in ("floor", "limit"))
    position_n, um = _position(closed, asked.place_mm, asked.forth_n)
    return Preview(
        effect if isinstance(effect, str) else getattr(effect, "kind", "effect"),
        shown,
        asked.place_mm,
        asked.forth_n,
        asked.back_n,
        low,
        high,
        table or shown.controller.model,
        open_loop,
        closed_loop,
        share_in_reach=float(np.average((wanted >= floor + d) & (wanted <= top + d), weights=np.abs(way))),
        share_clamped=asked.share_clamped,
        clamped_n=asked.clamped_n,
        steepest_n_mm=asked.steepest_n_mm,
        skin_n_mm=skin_n_mm(shown),
        position_error_um=um,
        position_error_n=position_n,
        table_error_n=asked.table_error_n,
    )


def prepared(effect: Effect | str, system: System, stroke: Strokes | float | None) -> System:
    """Return the system with an effect as its set-point and a stroke as its motion."""
    check_system(system)
    if not isinstance(system.motion, Strokes):
        raise FrictionloopError('system: motion.kind must be "strokes", such as in fl.bench()')
    if not isinstance(effect, (Effect, str, os.PathLike)):
        raise FrictionloopError(f"effect = {effect!r:.60}: must be an effect, a name of the library or a TOML file")
    effect = effect if isinstance(effect, Effect) else find(effect)
    kept = system.setpoint if isinstance(system.setpoint, EffectSource) else EffectSource()
    changes: dict[str, Any] = {"setpoint": kept.model_copy(update={"effect": effect})}
    if isinstance(stroke, Strokes):
        changes["motion"] = stroke
    elif stroke is not None and not isinstance(stroke, (int, float)):
        raise FrictionloopError(f"stroke = {stroke!r:.60}: must be a speed in mm/s or Strokes")
    elif stroke is not None:
        changes["motion.speed_mm_s"] = stroke
        changes["motion.reversal_s"] = min(system.motion.reversal_s, 0.5 * system.motion.stroke_mm / max(stroke, 1e-9))
    return system.evolve(changes)


def both(system: System, table: Model | None = None) -> dict[str, System]:
    """Return the system with the lookup alone, of its own table or another, and with its own law, by law."""
    if system.controller.kind == "lookup":
        raise FrictionloopError('controller.kind = "lookup": is the open loop; give the law that closes it')
    if table is not None and not isinstance(table, Model):
        raise FrictionloopError(f"table = {table!r:.60}: must be a controller's model, such as controller.model")
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


def _position(run: Any, place_mm: Array, asked_n: Array) -> tuple[float, float]:
    """Return what the error of the place does to the set-point, N rms, and how far that is on its slopes, um."""
    keep = run["scored"].values
    error = (run["f_r"].values - run["f_r_intended"].values)[keep]
    x = 1e3 * run["position"].values[keep]
    slope = np.interp(x, place_mm, np.gradient(asked_n, place_mm))
    rms = float(np.sqrt(np.mean(error**2)))
    steepness = float(np.sqrt(np.mean(slope**2)))
    return rms, 1e3 * rms / steepness if steepness > 1e-4 else 0.0
