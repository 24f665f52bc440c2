"""Does the loop ring? What a run shows, asked of the linear analysis, and gains that hold instead."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.parameters import System

CLAMPED, MISSING = 0.05, 0.1
"""A run is looked at if more commands than this are clamped, or R2 is further than this below its bound (chosen).

A bound that is itself this far below 1 explains clamped commands.
"""
SIGNS = ("saturation_index", "r2_identity")
"""Metrics in which ringing shows."""
CLOSE = 4.0
"""Ms above which a loop is said to be near ringing: less than 0.25 from -1, a phase margin below 15 degrees."""
HELD_PEAK = 2.0
"""Ms of the gains that are named instead, dry and moist: a phase margin of at least 29 degrees."""
FAR = 0.5
"""A population is looked at if its median R2 is further than this below its bound (chosen), as not all reach it."""
UNREACHED, OFTEN_N = 0.9, 0.2
"""Share of the time out of reach that is told, and the mean of a disturbance that is then asked about (chosen)."""
LOWEST_HZ = 5.0
"""Ringing is looked for above the tracking of a set-point (chosen)."""


class Band(NamedTuple):
    """The operating points that were looked at: the levels of the set-point, and states of the finger."""

    low_n: float
    high_n: float
    dry_and_moist: bool


class Ringing(NamedTuple):
    """A loop that rings or nearly does."""

    stable: bool
    frequency_hz: float | None
    """Where the error of a run has most power; None without a run: only clamping settles it."""
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


def ringing(run: xr.Dataset, mask: np.ndarray, metrics: dict[str, float]) -> Ringing | None:
    """Return what is known of a run that rings, None for one that shows no sign of it or is stable."""
    bound = metrics["r2_bound"]
    # A set-point out of reach clamps by itself. Of a constant one R2 is NaN: any such run is looked at.
    quiet = metrics["saturation_index"] <= CLAMPED or bound < 1.0 - MISSING
    calm = quiet and bound - metrics["r2_identity"] <= MISSING
    if calm or not mask.any():
        return None
    from frictionloop.loop.record import system_of

    found = of_system(system_of(run))
    return None if found is None else found._replace(frequency_hz=_loudest_hz(run, mask))


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
    return of_system(system) if bound - median_r2 > FAR else None


def of_system(system: System) -> Ringing | None:
    """Return what the linear analysis says of a system, dry and moist; None if it neither rings nor nearly does."""
    from frictionloop.analysis import operating_band
    from frictionloop.design import retune

    try:
        points = operating_band(system, occluded=(0.0, 1.0))
        margins = [point.margins() for point in points]
    except FrictionloopError:  # what cannot be linearised (a recording) is not judged
        return None
    stable, peak = all(each.stable for each in margins), max(each.sensitivity_peak for each in margins)
    if stable and peak < CLOSE:
        return None
    forces_n = [point.elements.force_n for point in points]
    band = Band(min(forces_n), max(forces_n), len({point.elements.occluded for point in points}) > 1)
    controller, known = system.controller, peak if stable else None
    from frictionloop.parameters import PiController

    if not isinstance(controller, PiController):
        return Ringing(stable, None, controller.kind, known, None, None, {}, band)
    try:
        held = {path: _three_digits(gain) for path, gain in retune(points, HELD_PEAK).overrides.items()}
    except FrictionloopError:
        held = {}
    return Ringing(stable, None, "pi", known, controller.kp, controller.ki, held, band)


def _loudest_hz(run: xr.Dataset, mask: np.ndarray) -> float:
    force = run["f_a" if "f_a" in run else "f_m"].values
    time, error = run["time"].values, np.where(mask, force - run["f_r"].values, 0.0)  # what was lost is NaN
    spectrum = np.abs(np.fft.rfft(error * np.hanning(error.size)))
    frequency = np.fft.rfftfreq(error.size, time[1] - time[0] if time.size > 1 else 1.0)
    spectrum[frequency < LOWEST_HZ] = 0.0
    return float(frequency[np.argmax(spectrum)])


def lines(found: Ringing, metrics: dict[str, float]) -> list[str]:
    """Return what a person is told."""
    clamped = metrics["saturation_index"]
    signs = [f"{clamped:.0%} of the commands are clamped"] if clamped > CLAMPED else []
    signs += ["the force does not follow"] if metrics["r2_identity"] < 0 else []
    near = "" if found.frequency_hz is None else f"{',' if found.stable else ''} near {found.frequency_hz:.3g} Hz"
    what = f"This loop {'is close to ringing' if found.stable else 'rings'}{near}"
    said = [what + (f": {', '.join(signs)}." if signs else ".")]
    said.append(f"{_gains(found)}: {'nearly ' if found.stable else ''}too much for this sensor, plate and delay.")
    if found.held:
        said.append(f"Gains that hold: {' '.join(f'--{path} {gain:g}' for path, gain in found.held.items())}")
        said.append(f"They hold {_where(found.band)}.")
    return said


def out_of_reach(run: xr.Dataset, mask: np.ndarray) -> list[str]:
    """Return what a person is told of a set-point that nearly nothing could follow, and what may be the cause."""
    if not mask.any():
        return []
    from frictionloop.loop.metrics import reach_of
    from frictionloop.loop.record import system_of

    (floor, top), r, d = reach_of(run, mask), run["f_r"].values[mask], run["d"].values[mask]
    missed = (r < floor + d) | (r > top + d)
    if not missed.mean() >= UNREACHED:
        return []
    low, high = float(np.median(floor + d)), float(np.median(top + d))
    said = [f"The set-point is out of reach {missed.mean():.0%} of the time: {low:.3g} to {high:.3g} N could be had."]
    system, level = system_of(run), abs(float(d.mean()))
    if level > OFTEN_N:
        mean = " --disturbance.remove_mean true" if system.disturbance.kind == "recording" else ""
        hint = f"did you mean{mean or ' a disturbance around 0'}?"
        said.append(f"The disturbance adds {d.mean():.3g} N on average, to friction that has its own mean; {hint}")
    elif np.median(r) > high:
        said.append(f"The finger's friction is too low for {np.median(r):.3g} N; did you mean a lower set-point?")
    else:
        said.append(f"No amplitude lowers it to {np.median(r):.3g} N; did you mean a higher set-point?")
    return said


def _gains(found: Ringing) -> str:
    if found.kp is not None and found.ki is not None:
        return f"kp = {found.kp:.3g}, ki = {found.ki:.4g}"
    peak = "unstable" if found.sensitivity_peak is None else f"Ms {found.sensitivity_peak:.3g}"
    return f"Law {found.law} as tuned ({peak} {_where(found.band)})"


def _where(band: Band) -> str:
    levels = f"{band.low_n:.3g}" + (f" to {band.high_n:.3g}" if band.high_n > band.low_n else "")
    return f"{'dry and moist, ' if band.dry_and_moist else ''}at the set-point's levels ({levels} N)"


def _three_digits(gain: float) -> float:
    """Return a gain with three digits, not above the one given."""
    if gain <= 0:
        return gain
    digit: float = 10.0 ** (math.floor(math.log10(gain)) - 2)
    return float(f"{math.floor(gain / digit) * digit:.3g}")


def as_json(found: Ringing | None) -> dict[str, Any] | None:
    """Return the same for a program."""
    return None if found is None else found._asdict() | {"band": found.band._asdict()}
