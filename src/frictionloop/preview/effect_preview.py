"""The preview of an effect: asked, delivered open loop, delivered closed, side by side."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionloop.analysis.stability import rings_if_linear
from frictionloop.findings import Finding, Result, shown
from frictionloop.loop.simulate import simulate
from frictionloop.parameters import Constant, Strokes, System
from frictionloop.parameters.controller import Model
from frictionloop.physics.reach import Reach
from frictionloop.preview.pattern_arrival import People, people
from frictionloop.preview.pattern_measures import LEAST_N, Delivered, delivered, over_place
from frictionloop.preview.prepared_stroke import StrokeForces, both, duration_s, playable_forces, prepared, skin_n_mm
from frictionloop.quantities import Array, FrictionloopError
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.effect_setpoint import EffectSource
from frictionloop.rendering.shapes import Grating

if TYPE_CHECKING:
    import pandas as pd  # type: ignore[import-untyped]
    from matplotlib.figure import Figure

REACHED = 0.995
"""Share of the path in reach below which that is a finding (assumed)."""


class Preview(Result, schema="rendering.preview/1"):
    """What will be felt of an effect under one finger; forces over ``place_mm``, shape (cells,)."""

    title: str
    """The name of the effect, or its kind."""
    system: System
    """The system with the effect as its set-point and the stroke as its motion."""
    open_loop: Delivered
    """What the lookup alone delivers, with ``table``."""
    closed_loop: Delivered
    """What the system's control law delivers."""
    people: People | None = None
    """What other fingers are given."""
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
    table_model: Model
    """What the lookup table of the open loop is made of."""
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
        both_ways = np.concatenate([self.asked_forth_n, self.asked_back_n])
        return 0.5 * float(both_ways.max() - both_ways.min())

    @property
    def arriving(self) -> tuple[str, str]:
        """What arrives, by name: of a pattern its contrast, of a level its error."""
        here, there = self.open_loop, self.closed_loop
        if not math.isfinite(here.contrast):
            errors = (f"{1e3 * abs(each.mean_error_n):.0f} mN" for each in (here, there))
            return "level errs", "{} open loop, {} closed".format(*errors)
        shares = f"{100 * here.contrast:.0f} % open loop, {100 * there.contrast:.0f} % closed"
        return "arrives", f"{shares}, within {duration_s(self.system):.0f} s of contact"

    def rows(self) -> list[tuple[str, str]]:
        """Return the effect, how much of it arrives, and how much it is felt."""
        effect = self.effect
        what = f"{effect.spacing_mm:g} mm grating" if isinstance(effect, Grating) else Path(self.title).stem
        height = f", ±{self.amplitude_n:.2g} N" if self.amplitude_n > LEAST_N else ""
        over = {"pattern": self.closed_loop.pattern_felt, "error": self.closed_loop.error_felt}
        times = {name: shown(each) if each >= 0.01 else "0" for name, each in over.items()}
        felt = ", ".join(f"{name} {each} x the threshold" for name, each in times.items())
        crowd = [] if self.people is None else [("between fingers", self.people.spread)]
        named = ("effect", f"{what}{height}, {self.speed_mm_s:g} mm/s")
        return [named, ("law", self.system.controller.kind), self.arriving, ("felt, closed", felt), *crowd]

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return what is delivered open and closed loop, what limits it, and what other fingers are given."""
        import pandas as pd

        columns = {"open loop": self.open_loop, "closed loop": self.closed_loop}
        limits = {
            "in reach, % of the path": 100.0 * self.share_in_reach,
            "clamped, % of the path": 100.0 * self.share_clamped,
            "clamped by, mN": 1e3 * self.clamped_n,
            "steepest rise, N/mm": self.steepest_n_mm,
            "skin, N/mm": self.skin_n_mm,
            "skin at this period, N": self.skin_amplitude_n,
            "position error, um": self.position_error_um,
            "of the set-point, mN": 1e3 * self.position_error_n,
            "table error, mN": 1e3 * self.table_error_n,
        }
        model = self.table_model
        table = {"f0, N": model.nominal_n, "tau, um^-2": model.susceptibility_per_um2}
        found = {
            "delivered": pd.DataFrame({name: _delivered(each) for name, each in columns.items()}),
            "limits": pd.DataFrame({"value": limits}),
            "table of the open loop": pd.DataFrame({"value": table | {"values measured": float(len(model.table_um2))}}),
        }
        return found if self.people is None else found | self.people.tables()

    def plot(self) -> Figure:
        """Return the map, forces over place, and what is felt."""
        from frictionloop.preview.effect_figure import figure_of

        return figure_of(self)


def _delivered(found: Delivered) -> dict[str, float]:
    return {
        "contrast, %": 100.0 * found.contrast,
        "behind its place, mm": found.moved_mm,
        "error, mN rms": 1e3 * found.rms_error_n,
        "mean error, mN": 1e3 * found.mean_error_n,
        "error felt, x threshold": found.error_felt,
        "pattern felt, x threshold": found.pattern_felt,
        "pattern at most, x threshold": float(np.nanmax(found.pattern_over)),
        "pattern felt, % of the path": 100.0 * found.share_felt,
    }


def preview(
    effect: Effect | str,
    system: System,
    stroke: Strokes | float | None = None,
    seed: int = 0,
    *,
    table: Model | None = None,
    fingers: Sequence[Mapping[str, Any]] = (),
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
    fingers : list of dict
        Other fingers, as of ``fl.fingers``, on which it is looked at too.

    Raises
    ------
    FrictionloopError
        For what is no effect, a stroke that the plate has no room for, or one on which nothing counts.
    """
    ready = prepared(effect, system, stroke)
    asked = playable_forces(ready)
    runs = {law: simulate(each, duration_s(ready), seed) for law, each in both(ready, table).items()}
    for run in runs.values():
        if not run["scored"].values.any():
            raise FrictionloopError("stroke: nothing counts; make it longer")
    open_loop, closed_loop = (delivered(run, law) for law, run in runs.items())
    closed = runs[ready.controller.kind]
    keep = closed["scored"].values
    names = ("f_r_intended", "limit", "floor", "d", "speed")
    wanted, top, floor, d, way = (closed[name].values[keep] for name in names)
    low, high = (np.fmin(*(over_place(closed, name, way) for way in (1.0, -1.0))) for name in ("floor", "limit"))
    position_n, um = _position(closed, asked.place_mm, asked.forth_n)
    reached = float(np.average(~Reach(floor, top).plus(d).beyond(wanted), weights=np.abs(way)))
    crowd = people(effect, system, fingers, stroke, seed, table=table) if fingers else None
    return Preview(
        title=effect if isinstance(effect, str) else getattr(effect, "kind", "effect"),
        system=ready,
        place_mm=asked.place_mm,
        asked_forth_n=asked.forth_n,
        asked_back_n=asked.back_n,
        low_n=low,
        high_n=high,
        table_model=table or ready.controller.model,
        open_loop=open_loop,
        closed_loop=closed_loop,
        people=crowd,
        share_in_reach=reached,
        share_clamped=asked.share_clamped,
        clamped_n=asked.clamped_n,
        steepest_n_mm=asked.steepest_n_mm,
        skin_n_mm=skin_n_mm(ready),
        position_error_um=um,
        position_error_n=position_n,
        table_error_n=asked.table_error_n,
        findings=(
            *_of_loop(ready, float(np.mean(wanted))),
            *findings_of(asked, ready),
            *_of_delivered(reached, closed_loop),
        ),
    )


def findings_of(asked: StrokeForces, system: System) -> Iterator[Finding]:
    """Yield what a controller's band and a skin take from an effect."""
    if asked.share_clamped > 0.0:
        by = {"by_mn": 1e3 * asked.clamped_n}
        yield Finding("EFFECT-CLAMPED", value=100.0 * asked.share_clamped, unit="%", more=by)
    skin = skin_n_mm(system)
    if asked.steepest_n_mm > skin:
        yield Finding("EFFECT-STEEP", value=asked.steepest_n_mm, unit="N/mm", limit=skin)


def _of_loop(system: System, force_n: float) -> Iterator[Finding]:
    """Yield that the loop rings at the mean force of the effect."""
    ringing = rings_if_linear(system.evolve({"setpoint": Constant(offset_n=force_n)}))
    if ringing is not None and ringing.finding is not None:
        yield ringing.finding


def _of_delivered(reached: float, closed: Delivered) -> Iterator[Finding]:
    if reached < REACHED:
        yield Finding("EFFECT-REACH", value=100.0 * reached, unit="%")
    if 0.0 < closed.pattern_felt < 1.0 and math.isfinite(closed.contrast):
        yield Finding("EFFECT-FAINT", value=closed.pattern_felt)


def _position(run: Any, place_mm: Array, asked_n: Array) -> tuple[float, float]:
    """Return what the error of the place does to the set-point, N rms, and how far that is on its slopes, um."""
    keep = run["scored"].values
    error = (run["f_r"].values - run["f_r_intended"].values)[keep]
    x = 1e3 * run["position"].values[keep]
    slope = np.interp(x, place_mm, np.gradient(asked_n, place_mm))
    rms = float(np.sqrt(np.mean(error**2)))
    steepness = float(np.sqrt(np.mean(slope**2)))
    return rms, 1e3 * rms / steepness if steepness > 1e-4 else 0.0
