"""Does the loop ring? What a run shows, asked of the linear analysis, and gains that hold instead."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.analysis.linear import LinearLoop
    from frictionloop.parameters import System

CLAMPED, MISSING = 0.05, 0.1
"""A run is looked at if more commands than this are clamped, or R2 is further than this below its bound (chosen).

A bound that is itself this far below 1 explains clamped commands.
"""
SIGNS = ("saturation_index", "r2_identity")
"""Metrics in which ringing shows."""
HELD_PEAK = 2.0
"""Ms of the gains that are named instead, dry and moist: a phase margin of at least 29 degrees."""
FAR = 0.5
"""A population is looked at if its median R2 is further than this below its bound (chosen), as not all reach it."""
OFF = 0.1
"""Share by which the resonance of the sensor may be off where gains are said to hold."""
RECORDED, OFTEN_N = ("recording", "samples"), 0.2
"""Kinds of disturbances that are measured, and the mean from which one is asked about (chosen)."""


class Band(NamedTuple):
    """The operating points that were looked at: the levels of the set-point, and states of the finger."""

    low_n: float
    high_n: float
    dry_and_moist: bool
    occluded: float
    """How moist the moist finger is, 0 to 1: a law is judged at the end of a contact, as it is designed; a PI at 1."""
    where: str
    """Contact, speed and resonance of the sensor, in words."""
    out_of_reach_n: tuple[float, ...] = ()
    """Forces asked for that are out of reach of every finger looked at; the nearest within stands for them."""


class Ringing(NamedTuple):
    """A loop that rings or nearly does."""

    stable: bool
    frequency_hz: float | None
    """Of the loop's least damped pole, or near it where a run has most power; None if neither is known."""
    law: str
    """Kind of the controller."""
    sensitivity_peak: float | None
    """Largest Ms of the points looked at; None if one is unstable."""
    kp: float | None
    ki: float | None
    """Gains of a PI law."""
    held: dict[str, float]
    """Gains that hold, as overrides; empty if none were found, or the law is not PI."""
    band: Band
    """Where they hold."""
    not_held: tuple[str, ...]
    """Contacts and speeds at which they do not."""
    also_held: tuple[str, ...] = ()
    """Other contacts and speeds at which they do, with the resonance off by `OFF`: Ms stays below `NEAR` there."""


def ringing(run: xr.Dataset, mask: np.ndarray, metrics: dict[str, float]) -> Ringing | None:
    """Return what is known of a run that rings, None for one that shows no sign of it or is stable."""
    if not mask.any():
        return None
    from frictionloop.loop.record import system_of

    system, bound = system_of(run), metrics["r2_bound"]
    recorded = "d" in run and system.disturbance.kind in RECORDED
    # A set-point out of reach clamps by itself. Of a constant one R2 is NaN: any such run is looked at.
    quiet = metrics["saturation_index"] <= CLAMPED or (bound < 1.0 - MISSING and not recorded)
    calm = quiet and bound - metrics["r2_identity"] <= MISSING
    if calm:
        return None
    found = of_system(around_levels(system, run, mask))
    if found is None or found.frequency_hz is None:
        return found
    return found._replace(frequency_hz=_loudest_hz(run, mask, found.frequency_hz))


def around_levels(system: System, run: xr.Dataset, mask: np.ndarray) -> System:
    """Return a system whose recorded signals are levels, of which the linear analysis knows.

    A disturbance is its mean; 0 for one that was left in, as `left_in` has it. A set-point is its mean, and a standard
    deviation to both sides.
    """
    from frictionloop.parameters import Constant, Sine

    levels: dict[str, Any] = {}
    if system.setpoint.kind in RECORDED:
        asked = run["f_r"].values[mask]
        levels["setpoint"] = Sine(offset_n=float(asked.mean()), amplitude_n=float(asked.std()))
    # With its mean removed the level is offset_n, as `design controller` takes it.
    if "d" in run and system.disturbance.kind in RECORDED and not getattr(system.disturbance, "remove_mean", False):
        mean_n = float(run["d"].values[mask].mean())
        levels["disturbance"] = Constant(offset_n=0.0 if left_in(system, mean_n) else mean_n)
    return system.evolve(levels) if levels else system


def left_in(system: System, mean_n: float) -> bool:
    """Tell whether a recorded disturbance seems to hold the mean friction, which the model has already."""
    removed = getattr(system.disturbance, "remove_mean", False)
    return system.disturbance.kind in RECORDED and not removed and abs(mean_n) > OFTEN_N


def of_recording(run: xr.Dataset, mask: np.ndarray) -> dict[str, float]:
    """Return the metrics that `ringing` asks of a device's recording; by the measured force where no other is known.

    What a controller could reach is not known of a real finger: the bound is taken as 1, so more runs are looked at.
    """
    import frictionloop as fl

    if not mask.any():
        return {"r2_identity": math.nan, "r2_bound": math.nan, "saturation_index": math.nan}
    known = run if "f_a" in run else run.assign(f_a=run["f_m"])
    found = {name: getattr(fl, name)(known, mask) for name in SIGNS}
    return found | {"r2_bound": 1.0}


def of_population(system: System, median_r2: float, duration_s: float) -> Ringing | None:
    """Return what the linear analysis says of the system of a population that follows badly, None if it holds."""
    if not median_r2 < 1.0 - FAR:  # also NaN; no bound is above 1
        return None
    from frictionloop.loop.sweep import sweep

    bound = sweep(system, [{}], duration_s, metrics=["r2_bound"], n_jobs=1, progress=False)["r2_bound"].values.item()
    found = of_system(system) if bound - median_r2 > FAR else None
    # What is clamped rings lower than the pole it grew from, and no run of a finger is kept that shows how low.
    return found if found is None or found.stable else found._replace(frequency_hz=None)


def of_system(system: System) -> Ringing | None:
    """Return what the linear analysis says of a system, dry and moist; None if it neither rings nor nearly does."""
    from frictionloop.analysis.reach import missed
    from frictionloop.analysis.stability import ringing_hz
    from frictionloop.design import retune
    from frictionloop.design.elsewhere import NEAR, elsewhere, in_words
    from frictionloop.parameters import PiController

    controller = system.controller
    try:
        points = points_of(system)
        peak = max(point.sensitivity_peak() for point in points)
    except FrictionloopError:  # what cannot be linearised (a recording) is not judged
        return None
    stable = math.isfinite(peak)
    if stable and peak < NEAR:
        return None
    states = {point.elements.occluded for point in points}
    # A moist finger that a force is out of reach of is looked at with the nearest: that is no level of the set-point.
    forces_n = [point.elements.force_n for point in points if point.elements.occluded == min(states)]
    beyond_n = [{each.force_n for each in missed(system, [state])} for state in sorted(states)]
    nowhere_n = tuple(sorted(set.intersection(*beyond_n)))
    band = Band(min(forces_n), max(forces_n), len(states) > 1, max(states), _bench(system), nowhere_n)
    known, rings_hz = peak if stable else None, ringing_hz(points)
    if not isinstance(controller, PiController):
        return Ringing(stable, rings_hz, controller.kind, known, None, None, {}, band, ())
    try:
        held = {path: _three_digits(gain) for path, gain in retune(points, HELD_PEAK).overrides.items()}
        there = elsewhere(system.evolve(held), {0.0: NEAR, OFF: NEAR})
        within = there.where("within")
        not_held = tuple(in_words(each for each in there.places if each not in within))
        also = () if not_held or there.unseen else tuple(in_words(within))
    except FrictionloopError:
        held, not_held, also = {}, (), ()
    return Ringing(stable, rings_hz, "pi", known, controller.kp, controller.ki, held, band, not_held, also)


def points_of(system: System) -> list[LinearLoop]:
    """Return the loops that are looked at: gains of a PI hold up to full occlusion, another law where it is designed.

    Raises
    ------
    FrictionloopError
        A loop that has no linear analysis.
    """
    from frictionloop.analysis import operating_band
    from frictionloop.design.corners import band_of
    from frictionloop.parameters import PiController

    plain = isinstance(system.controller, PiController)
    return operating_band(system, occluded=(0.0, 1.0)) if plain else band_of(system)


def _loudest_hz(run: xr.Dataset, mask: np.ndarray, loop_hz: float) -> float:
    """Return where the error of a run has most power, within half to twice the loop's frequency: not the tremor."""
    force = run["f_a" if "f_a" in run else "f_m"].values
    time, error = run["time"].values, np.where(mask, force - run["f_r"].values, 0.0)  # what was lost is NaN
    spectrum = np.abs(np.fft.rfft(error * np.hanning(error.size)))
    frequency = np.fft.rfftfreq(error.size, time[1] - time[0] if time.size > 1 else 1.0)
    spectrum[(frequency < loop_hz / 2) | (frequency > 2 * loop_hz)] = 0.0
    return float(frequency[np.argmax(spectrum)]) or loop_hz


def _bench(system: System) -> str:
    from frictionloop.design.corners import stroke_of
    from frictionloop.parameters import SuspendedSensor

    sensor = system.sensor
    sprung = f", sensor resonance {sensor.resonance_hz:g} Hz" if isinstance(sensor, SuspendedSensor) else ""
    return stroke_of(system) + sprung


def _three_digits(gain: float) -> float:
    """Return a gain with three digits, not above the one given."""
    if gain <= 0:
        return gain
    digit: float = 10.0 ** (math.floor(math.log10(gain)) - 2)
    return float(f"{math.floor(gain / digit) * digit:.3g}")


def as_json(found: Ringing | None) -> dict[str, Any] | None:
    """Return the same for a program."""
    return None if found is None else found._asdict() | {"band": found.band._asdict()}
