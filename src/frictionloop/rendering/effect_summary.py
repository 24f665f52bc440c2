"""An effect in a line, the forces that it asks for, and the effects that there are."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from frictionloop.findings import Result, shown
from frictionloop.findings.shown import between
from frictionloop.rendering.effect import Effect, Touch
from frictionloop.rendering.library import LIBRARY
from frictionloop.rendering.tables import Map, Wave

if TYPE_CHECKING:
    import pandas as pd  # type: ignore[import-untyped]

STARTED_S = 1e6
"""Time since a wave began at which it is over."""
SPEEDS_MM_S, LOADS_N = (20.0, -20.0, 100.0, -100.0), (0.3, 1.0)
"""What an effect is listed for (assumed: slow and fast, light and pressed)."""
FEW = 12
"""Values of a map that are listed one by one (assumed: a line)."""


class Listed(NamedTuple):
    """An effect of the library, and the forces that it asks for: both ways, slow and fast, light and pressed."""

    name: str
    kind: str
    least_n: float
    largest_n: float


@dataclass(frozen=True, kw_only=True)
class Effects(Result):
    """The effects of the library."""

    SCHEMA: ClassVar[str] = "rendering.effects/1"
    effects: tuple[Listed, ...]

    def tables(self) -> Mapping[str, pd.DataFrame]:
        """Return kind and forces by name."""
        import pandas as pd

        heads = {"least_n": "least, N", "largest_n": "largest, N"}
        return {"effects": pd.DataFrame(self.effects).set_index("name").rename(columns=heads).rename_axis("effect")}


def effects() -> Effects:
    """Return the effects of the library, each with the forces that it asks for in N."""
    return Effects(effects=tuple(Listed(name, each.kind, *range_n(each)) for name, each in LIBRARY.items()))


def range_n(effect: Effect) -> tuple[float, float]:
    """Return the least and the largest force on the middle 100 mm, N; of an effect of place alone 40 mm high."""
    place, across = np.linspace(-50.0, 50.0, 1001), np.linspace(-20.0, 20.0, 81)[:, np.newaxis]
    y = across if effect.is_static else 0.0
    times = [STARTED_S, *np.linspace(0.0, longest_s(effect), 33)]
    speeds, loads = ((20.0,), (0.5,)) if effect.is_static else (SPEEDS_MM_S, LOADS_N)
    touches = itertools.product(speeds, loads, times[:1] if effect.is_static else times)
    forces = [effect.asked(Touch(place, y, speed, load, time)) for speed, load, time in touches]
    return min(float(np.min(each)) for each in forces), max(float(np.max(each)) for each in forces)


def longest_s(effect: Effect) -> float:
    """Return how long the longest wave of an effect lasts, 0 without a wave."""
    if isinstance(effect, Wave):
        return effect.duration_s
    return max((longest_s(part) for part in effect.parts), default=0.0)


def summary(effect: Effect) -> str:
    """Return an effect in one line: its kind and its values, or those of its parts."""
    if isinstance(effect, Map) and effect.table.size > FEW:
        return _of_map(effect)
    if isinstance(effect, Wave) and len(effect.values_n) > FEW:
        ends = between(min(effect.values_n), max(effect.values_n), "N")
        return f"wave ({len(effect.values_n)} values, {ends}, {shown(effect.duration_s)} s)"
    own = [f"{name} {shown(value)}" for name, value in effect if name != "kind" and _is_value(value)]
    inside = ", ".join([*own, *(summary(part) for part in effect.parts)])
    return f"{effect.kind} ({inside})" if inside else effect.kind


def _of_map(made: Map) -> str:
    table = made.table
    size = " x ".join(map(str, table.shape[::-1])) if len(table) > 1 else str(table.size)
    ends = between(float(table.min()), float(table.max()), "N")
    return f"map ({size} values, {ends}, {shown(made.pitch_mm)} mm apart)"


def _is_value(value: Any) -> bool:
    return isinstance(value, (int, float, str)) or (isinstance(value, tuple) and isinstance(value[0], (float, tuple)))
