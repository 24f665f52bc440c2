"""What the page draws of an effect: its force over the plate, and a small picture of each of the library."""

from __future__ import annotations

import base64
from functools import cache
from typing import Any, cast

import numpy as np

from frictionloop.parameters import System
from frictionloop.rendering.effect import EFFECTS, Effect, Touch
from frictionloop.rendering.effect_setpoint import EffectSource
from frictionloop.rendering.library import LIBRARY
from frictionloop.studio.frames import pack_map

HEIGHT_MM = 60.0
"""Height of the plate that is shown (assumed)."""
CELL_MM = 0.25
"""Distance of the map's places: twice per half millimetre, the finest of the library's textures."""
PAINT_MM = 0.75
"""Distance of painted places: a plate of 255 by 60 mm is then within the values of a map."""
PAINT_MOST_N = 1.2
"""Force of the strongest paint, N: 255 steps from none (assumed: above what most fingers have without vibration)."""


def map_of(system: System) -> bytes:
    """Return the force that an effect asks for over the plate, as a message; one row where y does not matter."""
    half_x, half_y = system.touch.load.length_mm / 2, HEIGHT_MM / 2
    source = system.setpoint
    if not isinstance(source, EffectSource):
        return pack_map(np.zeros((1, 1)), -half_x, half_x, -half_y, half_y)
    x = np.arange(-half_x, half_x, CELL_MM) + CELL_MM / 2
    y = np.arange(-half_y, half_y, CELL_MM) + CELL_MM / 2
    force = force_over(source, x, y)
    if np.ptp(force, axis=0).max() < 1e-6:
        force = force[:1]
    return pack_map(force, -half_x, half_x, -half_y, half_y)


def force_over(source: EffectSource, x_mm: np.ndarray, y_mm: np.ndarray) -> np.ndarray:
    """Return the force over a grid, N, shape (y, x), for a finger of 0.5 N on its way forth long after the start."""
    x, y = np.meshgrid(x_mm, y_mm)
    force = source.effect.force_of(Touch(x, y, 20.0, 0.5, 1e6, 0.0))
    return np.array(np.broadcast_to(force, x.shape), float)


def depends_on_y(source: EffectSource, y_mm: float) -> bool:
    """Tell whether a stroke at this height asks for anything else than the one that is in force."""
    x = np.linspace(-120.0, 120.0, 961)
    here, there = force_over(source, x, np.array([source.track.y_mm, y_mm]))
    return bool(np.abs(here - there).max() > 1e-4)


def read_along(system: System, line_mm: float) -> System | None:
    """Return the System whose effect is read along the line of a finger that has landed; None if nothing changes."""
    source = system.setpoint
    if not isinstance(source, EffectSource) or line_mm == source.track.y_mm or not depends_on_y(source, line_mm):
        return None
    return system.evolve({"setpoint.track.y_mm": line_mm})


HALF_MM = 12.0, 3.0
"""Half of the width and of the height that a picture shows: a dozen periods of the finest, the edge of the walls."""
CELLS = 96, 24
WIDE = ("gradient", "chirp", "slider")
"""Effects that are longer than that: the whole plate is shown of them."""
WIDE_HALF_MM = 36.0, 9.0
BLACK_N, WHITE_N = 0.2, 0.75
"""Forces at both ends of grey, the same for all, so that a level looks like one (assumed: the library's range)."""


def effects() -> dict[str, Effect]:
    """Return what a page chooses from: the library, and kinds from outside with their values as they are."""
    own = {kind: EFFECTS[kind] for kind in sorted(EFFECTS.outside)}
    ready = {kind: made for kind, made in own.items() if not any(f.is_required() for f in made.model_fields.values())}
    return LIBRARY | {kind: cast(Effect, made()) for kind, made in ready.items()}


def gallery() -> list[dict[str, Any]]:
    """Return name, kind and picture of every effect: grey bytes, the lowest row first, as base64."""
    return [{"name": name, "picture": _picture(name, effect), "cells": CELLS} for name, effect in effects().items()]


@cache
def _picture(name: str, effect: Effect) -> str:
    half_x, half_y = WIDE_HALF_MM if name in WIDE else HALF_MM
    x, y = np.linspace(-half_x, half_x, CELLS[0]), np.linspace(-half_y, half_y, CELLS[1])
    force = force_over(EffectSource(effect=effect), x, y)
    share = np.clip((force - BLACK_N) / (WHITE_N - BLACK_N), 0.0, 1.0)
    return base64.b64encode(np.round(255 * share).astype(np.uint8).tobytes()).decode()
