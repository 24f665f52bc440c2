"""What the commands of effects print: rows of numbers and one object for JSON."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionloop.cli.describe import short
from frictionloop.cli.scores import between
from frictionloop.preview.asked import STARTED_S, longest_s
from frictionloop.preview.effect import skin_n_mm
from frictionloop.rendering.compiling import program_of
from frictionloop.rendering.effect import Touch
from frictionloop.rendering.source import EffectSource
from frictionloop.rendering.tables import Map

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.parameters import System
    from frictionloop.parameters.timing import Model
    from frictionloop.preview import Delivered, People, Preview
    from frictionloop.preview.asked import Asked
    from frictionloop.rendering.effect import Effect

_LIMITS = (
    *("share_in_reach", "share_clamped", "clamped_n", "steepest_n_mm", "skin_n_mm"),
    *("position_error_um", "position_error_n", "table_error_n"),
)


def library_rows(effects: Mapping[str, Effect]) -> list[tuple[str, str, str]]:
    """Return name, kind and range of force of each: both ways, slow and fast, light and pressed, with its waves."""
    rows = []
    for name, effect in effects.items():
        low, high = _range_n(effect)
        rows.append((name, effect.kind, between(low, high)))
    return rows


def _range_n(effect: Effect) -> tuple[float, float]:
    """Return the least and the largest force on the middle 100 mm."""
    place = np.linspace(-50.0, 50.0, 1001)
    times = [STARTED_S, *np.linspace(0.0, longest_s(effect), 33)]
    speeds, loads = ((20.0,), (0.5,)) if effect.is_static else (SPEEDS_MM_S, LOADS_N)
    touches = itertools.product(speeds, loads, times[:1] if effect.is_static else times)
    forces = [effect.asked(Touch(place, 0.0, speed, load, time)) for speed, load, time in touches]
    return min(float(np.min(each)) for each in forces), max(float(np.max(each)) for each in forces)


SPEEDS_MM_S, LOADS_N = (20.0, -20.0, 100.0, -100.0), (0.3, 1.0)
"""What an effect is listed for (assumed: slow and fast, light and pressed)."""


def described(effect: Effect) -> str:
    """Return an effect in one line: its kind and its values, or those of its parts."""
    if isinstance(effect, Map) and len(effect.values_n) * len(effect.values_n[0]) > FEW:
        return _described_map(effect)
    own = [f"{name} {short(value)}" for name, value in effect if name != "kind" and _is_value(value)]
    parts = [described(part) for part in effect.parts]
    inside = ", ".join([*own, *parts])
    return f"{effect.kind} ({inside})" if inside else effect.kind


FEW = 12
"""Values of a map that are told one by one (assumed: a line)."""


def _described_map(made: Map) -> str:
    table = made.table
    rest = ", ".join(f"{name} {short(value)}" for name, value in made if name not in ("kind", "values_n"))
    size = " x ".join(map(str, table.shape[::-1])) if len(table) > 1 else str(table.size)
    return f"map ({size} values from {table.min():.3g} to {table.max():.3g} N, {rest})"


def _is_value(value: Any) -> bool:
    return isinstance(value, (int, float, str)) or (isinstance(value, tuple) and isinstance(value[0], (float, tuple)))


def delivered_rows(shown: Preview) -> list[tuple[str, ...]]:
    """Return what arrives, open and closed loop, side by side."""
    both = shown.open_loop, shown.closed_loop

    def row(name: str, of: Any, unit: str) -> tuple[str, ...]:
        return (name, *(of(each) for each in both), unit)

    return [
        ("", "open loop", "closed loop", ""),
        row("contrast that arrives", lambda d: _percent(d.contrast), ""),
        row("pattern felt behind its place by", lambda d: f"{d.moved_mm:.2f}", "mm"),
        row("error of the force", lambda d: f"{1e3 * d.rms_error_n:.1f}", "mN rms"),
        row("of that its mean", lambda d: f"{1e3 * d.mean_error_n:.1f}", "mN"),
        row("error as felt", lambda d: _felt(d.error_felt), "times the threshold"),
        row("pattern as felt", lambda d: _felt(d.pattern_felt), "times the threshold"),
        row("pattern above the threshold", lambda d: _percent(d.share_felt), "of the path"),
        row("at most", lambda d: _felt(np.nanmax(d.pattern_over)), "times the threshold"),
    ]


def _felt(thresholds: float) -> str:
    return f"{thresholds:.3g}" if thresholds >= 0.01 else "0"


def _percent(share: float) -> str:
    return "–" if math.isnan(share) else f"{100 * share:.0f} %"


def limit_rows(shown: Preview) -> list[tuple[str, str]]:
    """Return what limits an effect before any controller does."""
    skin = skin_words(shown.skin_n_mm, shown.effect)
    return [
        ("open loop", f"the lookup alone, of {table_words(shown.table)}"),
        ("within reach", f"{100 * shown.share_in_reach:.0f} % of the scored path"),
        ("clamped", f"{100 * shown.share_clamped:.0f} % of the path, by at most {1e3 * shown.clamped_n:.0f} mN"),
        ("steepest rise", f"{shown.steepest_n_mm:.3g} N/mm; {skin}"),
        ("position error", f"{shown.position_error_um:.0f} um, {1e3 * shown.position_error_n:.1f} mN of the set-point"),
        ("table error", f"{1e3 * shown.table_error_n:.2g} mN"),
    ]


def skin_words(skin_n_mm: float, effect: Effect) -> str:
    """Return what the skin lets through, in words."""
    if math.isinf(skin_n_mm):
        return "a rigid finger"
    words = f"the skin lets through up to {skin_n_mm:.3g} N/mm"
    if effect.period_mm:
        words += f", a sine of {effect.period_mm:.3g} mm up to {skin_n_mm * effect.period_mm / (2 * math.pi):.2g} N"
    return words


def table_words(model: Model) -> str:
    """Return what a lookup table is made of, in words."""
    if model.table_um2:
        return f"a measured table of {len(model.table_um2)} values up to {model.nominal_n:.3g} N"
    return f"a table for f0 = {model.nominal_n:.3g} N and tau = {model.susceptibility_per_um2:.3g} /um2"


def as_json(shown: Preview, crowd: People | None) -> dict[str, Any]:
    """Return a preview as one object."""
    found: dict[str, Any] = {"sentence": shown.sentence, "effect": shown.effect.model_dump()}
    found |= {"speed_mm_s": shown.speed_mm_s} | {name: getattr(shown, name) for name in _LIMITS}
    found |= {"open_loop": _numbers(shown.open_loop), "closed_loop": _numbers(shown.closed_loop)}
    found |= {"open_loop_table": table_words(shown.table)}
    found |= {"place_mm": shown.place_mm, "asked_forth_n": shown.asked_forth_n, "asked_back_n": shown.asked_back_n}
    if crowd:
        found["fingers"] = {
            "sentence": crowd.sentence,
            "spread_n": dict(zip(("open_loop", "closed_loop"), crowd.spread_n, strict=True)),
            "contrast": dict(zip(("open_loop", "closed_loop"), crowd.contrasts, strict=True)),
        }
    return found


def _numbers(ways: Delivered) -> dict[str, Any]:
    return ways._asdict()


def checked_rows(system: System, asked: Asked) -> list[tuple[str, str]]:
    """Return what a check found."""
    found = checked_json(system, asked)
    return [
        ("effect", found["described"]),
        ("asks for", between(asked.least_n, asked.largest_n)),
        ("clamped", f"{100 * asked.share_clamped:.0f} % of the path, by at most {1e3 * asked.clamped_n:.0f} mN"),
        ("steepest rise", f"{asked.steepest_n_mm:.3g} N/mm; {found['skin']}"),
        (
            "compiled to",
            f"{found['instructions']} instructions, {found['values']} values, {found['triggers']} triggers",
        ),
        ("table error", f"{1e3 * asked.table_error_n:.2g} mN"),
    ]


def checked_json(system: System, asked: Asked) -> dict[str, Any]:
    """Return the same as one object."""
    source = system.setpoint
    assert isinstance(source, EffectSource)
    program = program_of(source.effect, source.track, system.touch.load.length_mm)
    return {
        "described": described(source.effect),
        "least_n": asked.least_n,
        "largest_n": asked.largest_n,
        "share_clamped": asked.share_clamped,
        "clamped_n": asked.clamped_n,
        "steepest_n_mm": asked.steepest_n_mm,
        "skin": skin_words(skin_n_mm(system), source.effect),
        "table_error_n": asked.table_error_n,
        "instructions": len(program.code),
        "values": program.values.size,
        "triggers": program.triggers,
    }


def run_errors(run: xr.Dataset) -> dict[str, float]:
    """Return the error of the force, and the part of it that is of the place; N rms over what counts."""
    keep = run["scored"].values
    if not keep.any():
        return {"rms_error_n": math.nan, "position_error_n": math.nan}
    wanted = run["f_r_intended"].values
    errors = (run[name].values - wanted for name in ("f_a", "f_r"))
    force, place = (float(np.sqrt(np.mean(error[keep] ** 2))) for error in errors)
    return {"rms_error_n": force, "position_error_n": place}


def error_rows(errors: Mapping[str, float]) -> list[tuple[str, str]]:
    """Return these errors as rows."""
    names = ("error of the force", "of the set-point, by the place")
    return [(name, f"{1e3 * value:.1f} mN rms") for name, value in zip(names, errors.values(), strict=True)]
