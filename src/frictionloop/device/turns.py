"""Where a finger turns, as the device measures it: there friction changes its sign, whatever the controller does."""

from __future__ import annotations

import numpy as np


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
