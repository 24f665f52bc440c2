"""Which samples of a recording the metrics count."""

from __future__ import annotations

import numpy as np

from frictionloop.parameters import System
from frictionloop.parameters.motion import Strokes
from frictionloop.physics.motion import scored_edge_m

LOAD_SHARE = 0.5
"""Share of the mean load below which nothing counts (parameters/motion, `unscored_n`)."""


def counted(sliding: np.ndarray, position_m: np.ndarray, load_n: np.ndarray, system: System | None) -> np.ndarray:
    """Return the samples that count: |x| <= `scored_edge_m`, N >= load_n / 2, while the finger slides.

    The rule of `simulate` (kernel/motion_tile), with the measured position and load for the true ones. A finger at the
    bench may rest where a simulated one never does, so that its reading must be valid besides. Without strokes in the
    System, or without a System, that is all.

    Parameters
    ----------
    sliding : array (time,) of bool
        Samples that arrived and whose reading was valid.
    position_m, load_n : array (time,)
        As measured; NaN where a sample was lost.
    system : System, optional
        What the device was set up from.
    """
    if system is None or not isinstance(system.motion, Strokes):
        return sliding.copy()
    edge_m = scored_edge_m(system.motion, system.finger)
    return sliding & (np.abs(position_m) <= edge_m) & (load_n >= LOAD_SHARE * system.motion.load_n)
