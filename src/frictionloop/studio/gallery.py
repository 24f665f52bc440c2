"""The library of effects as the page shows it: a small picture of each, and what it is in a word."""

from __future__ import annotations

import base64
from functools import cache
from typing import Any, cast

import numpy as np

from frictionloop.rendering.effect import EFFECTS, Effect
from frictionloop.rendering.library import LIBRARY
from frictionloop.rendering.source import EffectSource
from frictionloop.studio.plate import asked

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
    force = asked(EffectSource(effect=effect), x, y)
    share = np.clip((force - BLACK_N) / (WHITE_N - BLACK_N), 0.0, 1.0)
    return base64.b64encode(np.round(255 * share).astype(np.uint8).tobytes()).decode()
