"""Where a loop is looked at: the friction law that holds there, moisture, and the amplitude that gives the force."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from frictionloop.findings import Finding
from frictionloop.findings.shown import between
from frictionloop.parameters import (
    Constant,
    FingerFriction,
    Friction,
    LogSweep,
    Recording,
    Sine,
    Steps,
    Strokes,
    System,
)
from frictionloop.parameters.input_signals import ColouredNoise
from frictionloop.physics import reach
from frictionloop.physics.friction import Held, amplitude_for
from frictionloop.physics.occlusion import occlusion_after
from frictionloop.physics.reach import Reach
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.rendering.effect_setpoint import EffectSource

if TYPE_CHECKING:
    import xarray as xr

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
    from frictionloop.recordings.force_channel import mean_of, scaled

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


NOISE_BAND = 2.0
"""Standard deviations of a coloured noise that count as its band (assumed: it is inside 95 % of the time)."""


class ForceBand(NamedTuple):
    """Lowest, mean and highest friction force g(a) that set-point and disturbance ask for, N."""

    low_n: float
    mean_n: float
    high_n: float


def law_at(system: System, occluded: float = 0.0) -> Friction | Held:
    """Return the friction law that holds at the mean load and the stroke's speed, for small signals.

    f0 (N/N0)^n (v/v0)^p (1 + (M - 1) w) and tau (1 - l w) of `FingerFriction`, without roughness, tremor and drift;
    other friction is its own law.

    Parameters
    ----------
    system
        The loop.
    occluded
        How far occlusion has come, w: 0 just landed, 1 after long contact.

    Raises
    ------
    FrictionloopError
        For a w out of range, or a finger so slow or so light that the controller holds its output.
    """
    _check_place(system, occluded)
    return reach.law_at(system.friction, system.motion, occluded)


def force_band(system: System) -> ForceBand:
    """Return the friction forces f_r - d that the signals of a system ask for.

    Raises
    ------
    FrictionloopError
        For a recording whose level is not known without reading it.
    """
    r, d = _band(system.setpoint, "setpoint"), _band(system.disturbance, "disturbance")
    return ForceBand(r.low_n - d.high_n, r.mean_n - d.mean_n, r.high_n - d.low_n)


def mean_disturbance_n(system: System) -> float:
    """Return the mean of the disturbance, N; that of a recording counts as its offset."""
    disturbance = system.disturbance
    if isinstance(disturbance, Recording):
        return disturbance.offset_n
    if not hasattr(disturbance, "offset_n") and not isinstance(disturbance, Steps):
        return 0.0
    return _band(disturbance, "disturbance").mean_n


def reach_at(system: System, occluded: float = 0.0) -> Reach:
    """Return the friction forces that plate and controller model allow at a state of the finger, as of `law_at`."""
    _check_place(system, occluded)
    return reach.reach(system.friction, system.motion, _largest_um(system), (occluded,))


def check_reach(system: System) -> None:
    """Refuse a set-point that vibration cannot give at any time, whatever the law."""
    wanted, (low, high) = force_band(system), reach_at(system)
    if wanted.high_n <= low or wanted.low_n >= high:
        raise FrictionloopError(
            f"setpoint: {between(wanted.low_n, wanted.high_n, 'N')} asked, {low:.3g} to {high:.3g} N in reach"
            f"{_under(system)}{_would_reach(system, wanted, low) if wanted.high_n <= low else '; ask for less'}",
            "OUT-OF-REACH",
        )


def _would_reach(system: System, wanted: ForceBand, low_n: float) -> str:
    """Return which amplitude, and which finger, has the highest force; "" where neither is known."""
    friction = system.friction
    if wanted.high_n <= 0.0 or not (isinstance(friction, FingerFriction) and isinstance(system.motion, Strokes)):
        return ""
    amplitude_um = float(amplitude_for(wanted.high_n, law_at(system)))
    plate = f"{amplitude_um:.3g} um" if amplitude_um > 0.0 else "no amplitude"
    return f"; takes {plate}, or friction.nominal_n below {friction.nominal_n * wanted.high_n / low_n:.3g} N"


def operating_amplitude_um(system: System, occluded: float, amplitude_um: float | None, force_n: float | None) -> float:
    """Return the amplitude of an operating point given as amplitude, as force, or not at all (`linearise`)."""
    low, high = reach_at(system, occluded)
    if amplitude_um is not None and force_n is not None:
        raise FrictionloopError("amplitude_um, force_n: give one")
    if amplitude_um is not None:
        largest = _largest_um(system)
        if not 0 <= amplitude_um <= largest:
            raise must_be("amplitude_um", amplitude_um, f"between 0 and {largest:g}", "um")
        return float(amplitude_um)
    name, force = "force_n", force_n
    if force is None and isinstance(system.motion, Strokes):
        name, force = "mean of setpoint less disturbance", force_band(system).mean_n
    if force is None:
        force = (low + high) / 2
    if not low <= force <= high:
        raise must_be(name, force, f"between {low:.6g} and {high:g}{_under(system)}", "N")
    return float(amplitude_for(force, law_at(system, occluded)))


def _largest_um(system: System) -> float:
    return min(system.plate.max_amplitude_um, system.controller.model.max_amplitude_um)


def _under(system: System) -> str:
    motion = system.motion
    return f" at motion.load_n = {motion.load_n:g} N" if isinstance(motion, Strokes) else ""


def _check_place(system: System, occluded: float) -> None:
    """Refuse a state out of range, and a finger so slow or so light that the controller holds its output."""
    if not 0 <= occluded <= 1:
        raise must_be("occluded", occluded, "between 0 and 1")
    cells, motion = system.touch.load, system.motion
    if not isinstance(motion, Strokes):
        return
    for name, value, least, unit in (
        ("speed_mm_s", motion.speed_mm_s, cells.least_speed_mm_s, "mm/s"),
        ("load_n", motion.load_n, cells.touch_n, "N"),
    ):
        if value < least:
            raise FrictionloopError(f"motion.{name} = {value:g} {unit}: the controller needs {least:g}")


def _band(source: Any, name: str) -> ForceBand:
    if isinstance(source, EffectSource):
        return ForceBand(*source.band_n)
    if isinstance(source, Steps):
        levels = source.levels_n
        return ForceBand(min(levels), math.fsum(levels) / len(levels), max(levels))
    if not hasattr(source, "offset_n") or (isinstance(source, Recording) and not source.remove_mean):
        raise FrictionloopError(f'{name}.kind = "{source.kind}": give force_n or amplitude_um')
    swing = 0.0
    if isinstance(source, Sine | LogSweep):
        swing = abs(source.amplitude_n)
    elif isinstance(source, ColouredNoise):
        swing = NOISE_BAND * source.rms_n
    return ForceBand(source.offset_n - swing, source.offset_n, source.offset_n + swing)


class Missed(NamedTuple):
    """A force asked for that is out of reach, and the nearest within."""

    force_n: float
    instead_n: float
    occluded: float
    """State of the finger, 0 (just landed) to 1 (after long contact)."""

    @property
    def short_n(self) -> float:
        """How far the nearest is from what is asked for, N."""
        return abs(self.force_n - self.instead_n)


def missed(system: System, states: Sequence[float] = (0.0,)) -> list[Missed]:
    """Return which of lowest, mean and highest force of set-point less disturbance are out of reach, by state."""
    found = []
    for state in states:
        there = reach_at(system, state)
        found += [
            Missed(f, float(there.nearest(f)), state) for f in dict.fromkeys(force_band(system)) if there.beyond(f)
        ]
    return found


CONTACT_S = 10.0
"""How long a finger that never lifts is looked at, s: as long as a trial (paper, Sec. 4.2)."""


def occlusions(system: System) -> tuple[float, ...]:
    """Return how far occlusion is looked at, 0 to 1: landed for the first time, and `moistest`."""
    friction, motion = system.friction, system.motion
    if not (isinstance(friction, FingerFriction) and isinstance(motion, Strokes)):
        return (0.0,)
    return 0.0, moistest(friction, motion)


def moistest(friction: FingerFriction, motion: Strokes) -> float:
    """Return the occlusion at the end of many contacts one after another; of a finger that never lifts after 10 s."""
    if motion.contact_s == 0.0:
        return occlusion_after(friction, CONTACT_S, 0.0)
    return occlusion_after(friction, motion.contact_s, motion.lifted_s, math.inf)
