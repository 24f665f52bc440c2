"""Which samples of a recording count: for the metrics, and away from the turns of the finger.

At a turn friction changes its sign, whatever the controller does.
"""

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


def away_from_turns(position_m: np.ndarray, speed_m_s: np.ndarray, way_m: float) -> np.ndarray:
    """Return which samples are so far or farther from the turn before them and from the one after.

    Parameters
    ----------
    position_m, speed_m_s : array
        Measured position and speed, (samples,); NaN where a sample was lost.
    way_m : float
        Distance in m.

    Returns
    -------
    array of bool
        (samples,); a run without a turn is away from all of them.
    """
    position_m = np.asarray(position_m)
    going = np.sign(np.nan_to_num(np.asarray(speed_m_s)))
    samples = np.arange(going.size)
    moving = np.flatnonzero(going)
    if moving.size == 0:
        return np.ones(going.size, bool)
    # While it rests, or is not heard of, a finger goes where it went last.
    last = np.maximum.accumulate(np.where(going != 0, samples, moving[0]))
    turns = np.flatnonzero(np.diff(going[last]) != 0) + 1
    places = np.concatenate([[np.nan], position_m[turns], [np.nan]])  # nobody knows of turns before and after the run
    after = np.searchsorted(turns, samples, side="right")
    with np.errstate(invalid="ignore"):
        near = (np.abs(position_m - places[after]) < way_m) | (np.abs(position_m - places[after + 1]) < way_m)
    return ~near
