"""Recorded signals as levels, of which a design and the linear analysis know."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionloop.analysis.operating import force_band, reach_at
from frictionloop.findings import Finding
from frictionloop.parameters import Constant, Sine
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.parameters import System

SIGNALS = ("setpoint", "disturbance")
UNCLEAR = frozenset({"UNIT-DOUBT", "SIGN-DOUBT", "COLUMN-DOUBT"})
"""Doubts with which nothing else is said of a signal."""
RECORDED, OFTEN_N = ("recording", "samples"), 0.2
"""Kinds of signals that are measured, and the mean from which a disturbance is asked about (chosen)."""

ENDS = 0.01
"""Share of a set-point's range at each end that may be out of reach and is none: a sine is there 6 % of the time."""


def at_levels(system: System, run: xr.Dataset | None = None, mask: np.ndarray | None = None) -> System:
    """Return the system with levels in the place of recorded signals: of those in a run, or in their files without one.

    A set-point is a sine from its lowest to its highest value. A disturbance is its mean, or 0 where that was left in,
    as `left_in` has it. A device's recording knows no disturbance: its system keeps what it has.
    """
    levels: dict[str, Any] = {}
    if (asked := _range_and_mean("setpoint", system, run, mask)) is not None:
        low_n, high_n, *_ = asked
        levels["setpoint"] = Sine(offset_n=(high_n + low_n) / 2, amplitude_n=(high_n - low_n) / 2)
    if (added := _range_and_mean("disturbance", system, run, mask)) is not None:
        levels["disturbance"] = Constant(offset_n=0.0 if left_in(system, added[2]) else added[2])
    return system.evolve(levels) if levels else system


def left_in(system: System, mean_n: float) -> bool:
    """Tell whether a recorded disturbance seems to hold the mean friction, which the model has already."""
    removed = getattr(system.disturbance, "remove_mean", False)
    return system.disturbance.kind in RECORDED and not removed and abs(mean_n) > OFTEN_N


def misread(system: System, signals: Sequence[str] = SIGNALS) -> list[Finding]:
    """Return what is in doubt of the recorded ones of these signals.

    A mean is only where size, sign and name of the signals are not.

    Raises
    ------
    FrictionloopError
        As `read_recording`.
    """
    from frictionloop.recordings.plausibility import doubts_of  # readers of files, which most runs do without

    found = list(doubts_of(system, signals))
    other = any(each.code in UNCLEAR for each in found)
    mean = None if other or "disturbance" not in signals else _kept_mean(system)
    return found if mean is None else [mean, *found]


def _kept_mean(system: System) -> Finding | None:
    """Return that a recorded disturbance seems to hold the mean friction still; None where it does not.

    It seems to where its mean, and nothing else, puts what the set-point asks for out of reach.
    """
    added = _range_and_mean("disturbance", system, None, None)
    chosen_n = getattr(system.disturbance, "offset_n", 0.0)  # a level that somebody gave is meant
    if added is None or not left_in(system, added[2] - chosen_n):
        return None
    try:
        wanted, there = force_band(at_levels(system)), reach_at(system)
    except FrictionloopError:  # a signal from outside, or a finger that does not slide
        return None
    some_n = ENDS * (wanted.high_n - wanted.low_n)
    lowest_n, highest_n = wanted.low_n + some_n, wanted.high_n - some_n
    reached = there.covers(lowest_n, highest_n) and not too_wide(added[3], there.high_n - there.low_n)
    if not reached or there.covers(lowest_n - added[2], highest_n - added[2]):
        return None
    from frictionloop.recordings.plausibility import doubt

    array = system.disturbance.kind == "samples"
    return doubt("MEAN-DOUBT", "disturbance", added[2], {"remove_mean": True}, array=array, unit="N")


def too_wide(rms_n: float, span_n: float) -> bool:
    """Tell whether what varies by this rms goes as far from end to end as vibration reaches, or farther, at any mean.

    As rms <= (highest - lowest)/2 for whatever signal (Popoviciu).
    """
    return rms_n >= span_n / 2.0


def _range_and_mean(
    name: str, system: System, run: xr.Dataset | None, mask: np.ndarray | None
) -> tuple[float, float, float, float] | None:
    """Return lowest, highest, mean and rms about it in N of a recorded signal; None of another, or if not known."""
    signal = getattr(system, name)
    if signal.kind not in RECORDED:
        return None
    from frictionloop.recordings.read import mean_of, scaled

    if run is not None:
        column = {"setpoint": "f_r", "disturbance": "d"}[name]
        if column not in run:
            return None
        values = run[column].values[mask]
    elif signal.kind == "recording":
        values = scaled(signal).force
    else:
        values = np.asarray(signal.values_n)
    return float(np.min(values)), float(np.max(values)), mean_of(values), float(np.std(values))
