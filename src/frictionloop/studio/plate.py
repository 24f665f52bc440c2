"""What the page draws of a System: the effect over the plate, and where it will not arrive."""

from __future__ import annotations

import numpy as np

from frictionloop.parameters import System
from frictionloop.rendering.effect import Touch
from frictionloop.rendering.source import EffectSource
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
    force = asked(source, x, y)
    if np.ptp(force, axis=0).max() < 1e-6:
        force = force[:1]
    return pack_map(force, -half_x, half_x, -half_y, half_y)


def asked(source: EffectSource, x_mm: np.ndarray, y_mm: np.ndarray) -> np.ndarray:
    """Return the force over a grid, N, shape (y, x), for a finger of 0.5 N on its way forth long after the start."""
    x, y = np.meshgrid(x_mm, y_mm)
    force = source.effect.asked(Touch(x, y, 20.0, 0.5, 1e6, 0.0))
    return np.array(np.broadcast_to(force, x.shape), float)


def depends_on_y(source: EffectSource, y_mm: float) -> bool:
    """Tell whether a stroke at this height asks for anything else than the one that is in force."""
    x = np.linspace(-120.0, 120.0, 961)
    here, there = asked(source, x, np.array([source.track.y_mm, y_mm]))
    return bool(np.abs(here - there).max() > 1e-4)


def read_along(system: System, line_mm: float) -> System | None:
    """Return the System whose effect is read along the line of a finger that has landed; None if nothing changes."""
    source = system.setpoint
    if not isinstance(source, EffectSource) or line_mm == source.track.y_mm or not depends_on_y(source, line_mm):
        return None
    return system.evolve({"setpoint.track.y_mm": line_mm})
