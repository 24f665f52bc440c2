"""Effects by name, ready to be felt, listed and changed: each is plain data, with the forces that it asks for."""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import numpy as np

from frictionloop.findings import Result, shown
from frictionloop.findings.result import Tables
from frictionloop.findings.shown import between
from frictionloop.rendering.effect import Effect, Touch
from frictionloop.rendering.effect_composition import Directed, Trigger
from frictionloop.rendering.force_tables import Map, Wave
from frictionloop.rendering.shapes import (
    Chirp,
    Constant,
    Detents,
    Dots,
    Edge,
    Gradient,
    Grating,
    Ridge,
    Texture,
    Viscous,
)

CARRIER_N = 0.45
"""Force that bumps and notches are added to: in the middle of what most fingers reach (assumed)."""


def _click(force_n: float) -> Wave:
    """Return a pulse of force of 20 ms that fades out (a step of at most 5 ms is felt as a click)."""
    return Wave(values_n=(0.0, force_n, 0.6 * force_n, 0.2 * force_n, 0.0), rate_hz=200.0)


def _button() -> Effect:
    """Return a fall of friction while pressed, with a click at press and a weaker one at release."""
    return Trigger(
        on_load_n=0.8, off_load_n=0.5, then=Constant(level_n=0.3), otherwise=Constant(level_n=0.55),
        starts=_click(-0.15), ends=_click(0.08),
    )  # fmt: skip


def _switch() -> Effect:
    """Return two levels: pushed past 3 mm it clicks over to the lower, and stays until it is pushed back past -3 mm."""
    return Trigger(
        on_x_mm=3.0, off_x_mm=-3.0, then=Constant(level_n=0.35), otherwise=Constant(level_n=0.55),
        starts=_click(-0.15), ends=_click(0.15),
    )  # fmt: skip


def _slider() -> Effect:
    """Return a track of 60 mm with notches every 10 mm and walls at its ends."""
    rail = Constant(level_n=0.4) + Detents(amplitude_n=0.12, spacing_mm=10.0)
    return rail + _wall().at(30.0) + _wall().rotate(180.0).at(-30.0)


def _wall() -> Effect:
    """Return a rise of friction that a finger runs into."""
    return Edge(from_n=0.0, to_n=0.35, width_mm=2.0)


def _braille() -> Effect:
    """Return the cell of the letter r (dots 1, 2, 3, 5) again and again, read along its middle row."""
    cell = Dots(at_mm=((1.75, 2.5), (1.75, 0.0), (1.75, -2.5), (4.25, 0.0)))
    return cell.repeat(6.0)


LIBRARY: dict[str, Effect] = {
    "constant": Constant(level_n=CARRIER_N),
    "gradient": Gradient(),
    "grating": Grating(),
    "square": Grating(shape="square", spacing_mm=4.0),
    "triangle": Grating(shape="triangle", spacing_mm=4.0),
    "chirp": Chirp().at(-30.0),
    "edge": Edge(),
    "bump": Constant(level_n=CARRIER_N) + Ridge(),
    "hole": Constant(level_n=CARRIER_N) + Ridge(height_mm=-0.5),
    "detents": Constant(level_n=CARRIER_N) + Detents(),
    "button": _button(),
    "switch": _switch(),
    "slider": _slider(),
    "wall": Constant(level_n=0.3) + _wall().at(10.0),
    "rough": Texture(),
    "velvet": Directed(forth=Constant(level_n=0.35), back=Constant(level_n=0.5))
    + Grating(offset_n=0.0, amplitude_n=0.02, spacing_mm=1.0),
    "liquid": Constant(level_n=0.25) + Viscous(per_speed_n_s_m=2.0),
    "rubber": Constant(level_n=0.6) + Texture(offset_n=0.0, rms_n=0.03, exponent=2.0, longest_mm=8.0),
    "braille": _braille(),
}
"""Ready-made effects; velvet has a mean by direction and a ripple of 1 mm (Bueno 2014); other numbers are assumed."""


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


class Effects(Result, schema="rendering.effects/1"):
    """The effects of the library."""

    effects: tuple[Listed, ...]

    def tables(self) -> Tables:
        """Return kind and forces by name."""
        import pandas as pd  # type: ignore[import-untyped]

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
    forces = [effect.force_of(Touch(place, y, speed, load, time)) for speed, load, time in touches]
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
