"""Does the loop of a run ring: by linear analysis at the levels it ran at, and kept up by its clamp."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from frictionloop.analysis.operating_point import at_levels, moistest
from frictionloop.analysis.stability import NEAR, OPEN, Ringing, rings
from frictionloop.findings import Condition, Finding
from frictionloop.findings.catalogue import Severity
from frictionloop.loop.companion_runs import steady_of, swing_n
from frictionloop.loop.metrics import out_of_reach, saturation_index
from frictionloop.loop.record import system_of
from frictionloop.loop.run_findings import CLAMPED
from frictionloop.parameters import FingerFriction, Strokes, System
from frictionloop.physics.occlusion import occlusion_at
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    import xarray as xr


SWING_N = 0.02
"""Swing of the force on a smooth finger, peak to peak, from which a law is said to ring (assumed)."""


def run_ringing(run: xr.Dataset, mask: np.ndarray) -> Ringing | None:
    """Return whether the loop of a run rings, at the frequency that is loudest in its error; None of an open loop.

    Raises
    ------
    FrictionloopError
        A law or a place without a linear analysis.
    """
    system = system_of(run)
    if system.controller.kind in OPEN or not mask.any():
        return None
    found = rings(at_levels(system, run, mask), _states(system, run.sizes["time"] / system.controller.rate_hz))
    found = replace(found, where=Condition(force_n=found.where.force_n, occluded=found.where.occluded))
    if found.how == "unstable" and found.frequency_hz is not None and saturation_index(run, mask) > CLAMPED:
        return replace(found, frequency_hz=loudest_hz(run, mask, found.frequency_hz))
    return found


def _states(system: System, duration_s: float) -> tuple[float, ...]:
    """Return the states of the finger that are looked at, moister where a run lasts longer."""
    friction, motion = system.friction, system.motion
    if not (isinstance(friction, FingerFriction) and isinstance(motion, Strokes)):
        return (0.0,)
    at_end = occlusion_at(friction, motion.contact_s, motion.lifted_s, duration_s)
    return 0.0, max(moistest(friction, motion), at_end)


def rings_alone(run: xr.Dataset, mask: np.ndarray, found: Ringing | None) -> bool:
    """Tell whether a loop rings whatever the disturbance.

    That is one that is unstable on a finger just landed. One that is close to it, or unstable on a moist finger alone,
    is asked whether it is clamped with the mean of the disturbance alone, where a set-point out of reach does not
    explain that: once it swings between the ends of its clamp it does not come to rest.
    """
    if found is None or found.how == "calm":
        return False
    if found.how == "unstable" and found.dry:
        return True
    calm = steady_of(run, mask) if "d" in run else None
    if calm is None or float(out_of_reach(calm, mask).mean()) > CLAMPED:
        return False
    return saturation_index(calm, mask) > CLAMPED


def of_ringing(found: Ringing | None, alone: bool, remedy: str = "--advise") -> Iterator[Finding]:
    """Yield that a loop rings or nearly does."""
    if found is None or found.how == "calm":
        return
    if found.how == "unstable":
        severity: Severity | None = "error" if alone else None
        hz = found.frequency_hz
        yield Finding("LOOP-UNSTABLE", severity, hz, "Hz", where=found.where, remedy=remedy)
    elif alone:
        peak: Mapping[str, float] = {"peak": found.sensitivity_peak}
        yield Finding("RING-CLAMP", value=found.frequency_hz, unit="Hz", where=found.where, more=peak)
    else:
        yield Finding("LOOP-NEAR", value=found.sensitivity_peak, limit=NEAR, where=found.where)


def of_own_law(system: System, force_n: float) -> Iterator[Finding]:
    """Yield that a law from outside, whose slope may say nothing of larger steps, makes the force swing."""
    if type(system.controller).__module__.startswith("frictionloop."):
        return
    swing = swing_n(system, force_n)
    if swing > SWING_N:
        yield Finding("LAW-CONTRADICTS", value=1e3 * swing, unit="mN", limit=1e3 * SWING_N)


def of_loop(rms_error_n: float, open_loop_rms_error_n: float) -> Iterator[Finding]:
    """Yield that a loop leaves more than the lookup table alone."""
    if rms_error_n > open_loop_rms_error_n:
        yield Finding("LOOP-WORSE", value=1e3 * rms_error_n, unit="mN", limit=1e3 * open_loop_rms_error_n)


def unseen(run: xr.Dataset, mask: np.ndarray, error: FrictionloopError) -> Iterator[Finding]:
    """Yield that it is not known whether a loop rings whose commands are clamped."""
    if saturation_index(run, mask) > CLAMPED:
        yield Finding("PLACE-UNSEEN", more={"reason": str(error)})


def loudest_hz(run: xr.Dataset, mask: np.ndarray, loop_hz: float) -> float:
    """Return where the error of a run has most power, within half to twice the loop's frequency: not the tremor.

    An error that is largest at an end of that is none of the loop's frequency, which is returned then.
    """
    force = run["f_a" if "f_a" in run else "f_m"].values
    time, error = run["time"].values, np.where(mask, force - run["f_r"].values, 0.0)  # what was lost is NaN
    spectrum = np.abs(np.fft.rfft(error * np.hanning(error.size)))
    frequency = np.fft.rfftfreq(error.size, time[1] - time[0] if time.size > 1 else math.inf)
    (near,) = np.nonzero((frequency >= loop_hz / 2) & (frequency <= 2 * loop_hz))
    loudest = int(np.argmax(spectrum[near])) if near.size else 0
    return float(frequency[near[loudest]]) if 0 < loudest < near.size - 1 else loop_hz
