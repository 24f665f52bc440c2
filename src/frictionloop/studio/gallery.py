"""The library of effects as the page shows it: a small picture of each, and what it is in a word."""

from __future__ import annotations

import base64
from functools import cache
from typing import Any

import numpy as np

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


@cache
def gallery() -> list[dict[str, Any]]:
    """Return name, kind and picture of every effect of the library: grey bytes, the lowest row first, as base64."""
    return [{"name": name, "picture": _picture(name), "cells": CELLS} for name in LIBRARY]


def _picture(name: str) -> str:
    half_x, half_y = WIDE_HALF_MM if name in WIDE else HALF_MM
    x, y = np.linspace(-half_x, half_x, CELLS[0]), np.linspace(-half_y, half_y, CELLS[1])
    force = asked(EffectSource(effect=LIBRARY[name]), x, y)
    share = np.clip((force - BLACK_N) / (WHITE_N - BLACK_N), 0.0, 1.0)
    return base64.b64encode(np.round(255 * share).astype(np.uint8).tobytes()).decode()
