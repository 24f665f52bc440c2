"""An effect without running it, and under a simulated finger."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from frictionloop.findings import Result, shown
from frictionloop.findings.shown import between
from frictionloop.loop.simulate import simulate
from frictionloop.parameters import Strokes, System
from frictionloop.preview.effect_preview import findings_of
from frictionloop.preview.prepared_stroke import playable_forces, prepared, skin_n_mm
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.effect_player import program_of
from frictionloop.rendering.effect_setpoint import EffectSource
from frictionloop.rendering.library import summary


class Check(Result, schema="rendering.check/1"):
    """What an effect asks for along a stroke, and what a controller's band and a skin leave of it."""

    effect: Effect
    least_n: float
    """Least force before the band, also while waves of it play."""
    largest_n: float
    share_clamped: float
    """Share of the path outside the band that the controller believes in."""
    clamped_n: float
    """By how much at most."""
    steepest_n_mm: float
    skin_n_mm: float
    """Stiffness of the skin; inf for a rigid finger."""
    skin_amplitude_n: float
    """Largest sine of the effect's period that the skin carries; NaN without a period."""
    instructions: int
    values: int
    """Of its table."""
    triggers: int
    table_error_n: float
    """Largest difference between the effect and the table that it is compiled to."""

    def rows(self) -> list[tuple[str, str]]:
        """Return the effect, its forces, its steepness, and what it is compiled to."""
        sine = self.skin_amplitude_n
        carried = f", a sine of {self.effect.period_mm:.3g} mm up to {shown(sine)} N" if math.isfinite(sine) else ""
        return [
            ("effect", summary(self.effect)),
            ("asks for", between(self.least_n, self.largest_n, "N")),
            ("rises", f"{shown(self.steepest_n_mm)} N/mm; the skin {shown(self.skin_n_mm)} N/mm{carried}"),
            ("compiled to", f"{self.instructions} instructions, {self.values} values, {self.triggers} triggers"),
            ("table error", f"{1e3 * self.table_error_n:.2g} mN"),
        ]


def check(effect: Effect | str, system: System, stroke: Strokes | float | None = None) -> Check:
    """Return what an effect asks for along a stroke, without running it.

    Parameters
    ----------
    effect, system, stroke
        As of `preview`.

    Raises
    ------
    FrictionloopError
        For forces out of reach everywhere, and for a period that is too short to be felt or played at this speed.
    """
    ready = prepared(effect, system, stroke)
    asked, source, skin = playable_forces(ready), ready.setpoint, skin_n_mm(ready)
    assert isinstance(source, EffectSource)
    program = program_of(source.effect, source.track, ready.touch.load.length_mm)
    return Check(
        effect=source.effect,
        least_n=asked.least_n,
        largest_n=asked.largest_n,
        share_clamped=asked.share_clamped,
        clamped_n=asked.clamped_n,
        steepest_n_mm=asked.steepest_n_mm,
        skin_n_mm=skin,
        skin_amplitude_n=skin * (source.effect.period_mm or math.nan) / (2.0 * math.pi),
        instructions=len(program.code),
        values=program.values.size,
        triggers=program.triggers,
        table_error_n=asked.table_error_n,
        findings=tuple(findings_of(asked, ready)),
    )


class Played(Result, schema="rendering.play/1", without="run"):
    """A run of an effect."""

    title: str
    """The name of the effect, or its kind."""
    run: xr.Dataset
    """As of ``fl.simulate``; ``f_r_intended`` is what the effect asks for at the true place."""
    duration_s: float
    seed: int
    rms_error_n: float
    """Of the force on the finger against what was intended, N rms; NaN where nothing counts."""
    position_error_n: float
    """Of the set-point, by the error of the place."""

    def rows(self) -> list[tuple[str, str]]:
        """Return the errors."""
        return [
            ("effect", f"{self.title}, {self.duration_s:g} s"),
            ("error", f"{shown(1e3 * self.rms_error_n)} mN rms of the force"),
            ("by the place", f"{shown(1e3 * self.position_error_n)} mN rms of the set-point"),
        ]


def play(effect: Effect | str, system: System, duration_s: float = 10.0, seed: int = 0) -> Played:
    """Return a run of an effect under the finger of a system.

    Parameters
    ----------
    effect, system, seed
        As of `preview`.
    duration_s
        Duration of the run, s.

    Raises
    ------
    FrictionloopError
        As `check`.
    """
    ready = prepared(effect, system, None)
    asked = playable_forces(ready)
    run = simulate(ready, duration_s, seed)
    keep, wanted = run["scored"].values, run["f_r_intended"].values
    errors = ((run[name].values - wanted)[keep] for name in ("f_a", "f_r"))
    force, place = (float(np.sqrt(np.mean(each**2))) if keep.any() else math.nan for each in errors)
    return Played(
        title=effect if isinstance(effect, str) else getattr(effect, "kind", "effect"),
        run=run,
        duration_s=duration_s,
        seed=seed,
        rms_error_n=force,
        position_error_n=place,
        findings=tuple(findings_of(asked, ready)),
    )
