"""Where the stroke of a finger runs over an effect: contact stays one-dimensional, along a straight line."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from frictionloop.parameters.block import Block, Number
from frictionloop.rendering.effect import Touch


class Track(Block):
    """Where the stroke of a finger runs over an effect: a straight line."""

    x_mm: Number = 0.0
    """Place of the middle of the stroke along the plate."""
    y_mm: Number = 0.0
    """Place of the middle of the stroke across the plate."""
    heading_deg: Number = 0.0
    """Direction of the stroke against x."""

    def touch(self, along_mm: Any, speed_mm_s: Any = 0.0, load_n: Any = 0.5, time_s: Any = 0.0) -> Touch:
        """Return the touch at a way along the path from the middle of the stroke."""
        c, s = math.cos(math.radians(self.heading_deg)), math.sin(math.radians(self.heading_deg))
        x, y = self.x_mm + c * np.asarray(along_mm, float), self.y_mm + s * np.asarray(along_mm, float)
        return Touch(x, y, speed_mm_s, load_n, time_s, self.heading_deg)
