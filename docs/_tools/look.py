"""How figures look in the documentation: the report's style, and the colours in a fixed order."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
from cycler import cycler

from frictionloop.figures.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, STYLE, VERMILLION

LOOK: dict[str, Any] = STYLE | {
    "axes.prop_cycle": cycler(color=[BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY, BLACK]),
    "figure.constrained_layout.use": True,
    "figure.figsize": (6.6, 3.2),
}


def dress(_gallery: dict[str, Any], _example: str) -> None:
    """Set the look before an example of the gallery runs."""
    mpl.rcParams.update(LOOK)
