"""``frictionloop compare`` on effects: how much of a pattern arrives under each law."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from frictionloop.cli import checks, screen
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.design.comparison.effects import Cell, Key
    from frictionloop.parameters import System
    from frictionloop.rendering.effect import Effect

ALREADY = "setpoint"
"""What the effect is called that a system has as its set-point."""
LEGEND = (
    "arrives: slope of the force on the finger over what the effect asks for, median (deciles) of the capable fingers",
    "error: of the force, rms, median / worst decile; felt: the same in thresholds of touch; pattern: of the pattern",
    "between: how differently fingers are given the effect, standard deviation of the force at a place",
)
"""What the heads of the table mean."""


def wanted(system: System, names: str | None) -> Mapping[str, Effect]:
    """Return the effects to compare on: those that are named, or that which a system has as its set-point."""
    from frictionloop.rendering.files import find
    from frictionloop.rendering.source import EffectSource

    if names is not None:
        return {name.strip(): find(name.strip()) for name in names.split(",")}
    return {ALREADY: system.setpoint.effect} if isinstance(system.setpoint, EffectSource) else {}


def refuse(options: Mapping[str, Any]) -> None:
    """Refuse options that only the comparison on the paper's set-points takes, those that are given."""
    for name, value in options.items():
        if value:
            raise FrictionloopError(
                f"{name} = {value}: goes with the paper's set-points; on effects take --csv, --json"
            )


def compare(
    system: System,
    origin: str,
    effects: Mapping[str, Effect],
    fingers: int,
    seed: int,
    laws: list[str] | None,
    speeds: list[float],
    csv: Path | None,
    json: bool,
) -> None:
    """Run and show it."""
    with screen.waiting("loading what compares"):
        from frictionloop.design.comparison.effects import compare_effects

    cells = compare_effects(system, effects, fingers, seed, laws, speeds)
    rows = [{"law": law, "effect": effect, "speed_mm_s": speed} | cell for (law, effect, speed), cell in cells.items()]
    if csv is not None:
        checks.write_csv(csv, rows)
    saved = {"table": csv}
    if json:
        about = {"system": system.model_dump(), "effects": {name: each.model_dump() for name, each in effects.items()}}
        screen.show_json(about | {"fingers": fingers, "seed": seed, "scores": rows, "saved": saved})
        return
    said = f"{origin}, {fingers} fingers of seed {seed}, the capable of them"
    blocks = [line for name in effects for speed in speeds for line in _block(cells, name, speed)]
    screen.show(screen.columns([("bench", said)]), "", *blocks, *LEGEND, *screen.saved(saved))


def _block(cells: Mapping[Key, Cell], effect: str, speed: float) -> list[str]:
    """Return the table of an effect at a speed, a row for each law."""
    here = {law: cell for (law, name, at), cell in cells.items() if (name, at) == (effect, speed)}
    count = int(next(iter(here.values()))["fingers"])
    heads = ("law", "arrives, %", "error, mN", "felt", "pattern", "between, mN", "")
    rows = [(law, *_row(cell)) for law, cell in here.items()]
    return [f"{effect} at {speed:g} mm/s, {count} fingers", screen.table([heads, *rows]), ""]


def _row(cell: Cell) -> tuple[str, ...]:
    whole = math.isfinite(cell["contrast"])
    arrives = "{:.0f} ({:.0f} to {:.0f})".format(*(100 * cell[f"contrast{end}"] for end in ("", "_low", "_high")))
    return (
        arrives if whole else "-",
        f"{1e3 * cell['rms_error_n']:.0f} / {1e3 * cell['rms_error_n_worst']:.0f}",
        f"{cell['error_felt']:.0f} / {cell['error_felt_worst']:.0f}",
        f"{cell['pattern_felt']:.0f}",
        f"{1e3 * cell['spread_n']:.0f}",
        "",
    )
