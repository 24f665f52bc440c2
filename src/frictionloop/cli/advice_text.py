"""What a person is told of a loop that rings, of a set-point that nothing could follow, and of a low ceiling."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from frictionloop.cli.advice import CLAMPED
from frictionloop.cli.one_place import WITHOUT_CHECK
from frictionloop.cli.ringing import HELD_PEAK, OFF, Band, Ringing
from frictionloop.cli.scores import between

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.parameters import System

UNREACHED = 0.9
"""Share of the time out of reach that is told (chosen); less where a recording brings its own mean."""
MISSED, TINY = 0.05, 1e-300
"""Share of the time out of reach from which the error is split (chosen), and what keeps a share of nothing a number."""
WIDTH = 100
NEAR = 4.0
"""As in the design of controllers, which this does not load; a test holds the two together."""
LEADS = (
    "They stop the ringing of this PI. The answer to go by is that of `frictionloop design controller FILE`: its law "
    "has a notch, and holds its limits with the resonance off."
)
AGAIN = (
    "This is the law with its own filters, at the speed of this run. `frictionloop design controller FILE --speeds "
    "SLOWEST,FASTEST` designs it for a range of speeds."
)
AT_CEILING, FAR_N = 0.2, 0.02
"""Share of the time at the ceiling, and the mean error there, from which the ceiling is named (chosen)."""


def too_late(system: System, metrics: dict[str, float]) -> list[str]:
    """Return lines on a loop whose commands are clamped, and whose delay is too long for the linear analysis."""
    from frictionloop.analysis.sampled import LONGEST_DELAY

    periods, clamped = round(system.controller.delay_s * system.controller.rate_hz), metrics["saturation_index"]
    if periods <= LONGEST_DELAY or clamped <= CLAMPED or system.controller.kind in WITHOUT_CHECK:
        return []
    why = f"a delay of {periods} control periods is beyond the {LONGEST_DELAY} that the linear analysis takes"
    return textwrap.wrap(
        f"{clamped:.0%} of the commands are clamped. Whether this loop rings is not known: {why}.", WIDTH
    )


def lines(found: Ringing, metrics: dict[str, float], swings: bool = False) -> list[str]:
    """Return what a person is told; ``swings`` of a loop that its clamp keeps swinging whatever the disturbance."""
    clamped = metrics["saturation_index"]
    signs = [f"{clamped:.0%} of the commands are clamped"] if clamped > CLAMPED else []
    signs += ["the force does not follow"] if metrics["r2_identity"] < 0 else []
    near = "" if found.frequency_hz is None else f"{',' if found.stable else ''} near {found.frequency_hz:.3g} Hz"
    moist = f" on a moist finger (occluded {found.band.occluded:.0%}), not on one just landed" * found.moist_alone
    close = "rings between the ends of its clamp, though a small change dies out" if swings else "is close to ringing"
    what = f"This loop {close if found.stable else 'rings'}{near}{moist}"
    said = textwrap.wrap(what + (f": {', '.join(signs)}." if signs else "."), WIDTH)
    said.append(
        f"{_gains(found)}: {'nearly ' if found.stable and not swings else ''}too much for this sensor, plate and delay."
    )
    if found.held:
        said.append(f"Gains that hold: {' '.join(f'--{path} {gain:g}' for path, gain in found.held.items())}")
        holds = f"They hold with Ms up to {HELD_PEAK:g}, {_where(found.band)}{found.band.where}, for this finger."
        said += textwrap.wrap(holds, WIDTH)
        if found.not_held:
            said += textwrap.wrap(f"They do not hold on {'; on '.join(found.not_held)}.", WIDTH)
        elif found.also_held:
            also = f"Ms stays below {NEAR:g} with the resonance {OFF:.0%} off, also on {'; on '.join(found.also_held)}."
            said += textwrap.wrap(also, WIDTH)
        said += textwrap.wrap(LEADS, WIDTH) if found.springs else []
    elif found.law != "pi":
        said += textwrap.wrap(AGAIN, WIDTH)
    return said


def _gains(found: Ringing) -> str:
    if found.kp is not None and found.ki is not None:
        return f"kp = {found.kp:.3g}, ki = {found.ki:.4g}"
    peak = "unstable" if found.sensitivity_peak is None else f"Ms {found.sensitivity_peak:.3g}"
    return f"Law {found.law} as tuned ({peak} {_where(found.band)})"


def _where(band: Band) -> str:
    states = f"dry and moist (occluded {band.occluded:.0%}), " if band.dry_and_moist else ""
    beyond = " and ".join(f"{force:.3g}" for force in band.out_of_reach_n)
    missing = f"; {beyond} N is out of reach" if beyond else ""
    return f"{states}at the set-point's levels ({between(band.low_n, band.high_n)}{missing})"


def out_of_reach(run: xr.Dataset, mask: np.ndarray) -> list[str]:
    """Return what a person is told of a set-point that nearly nothing could follow, and what may be the cause."""
    from frictionloop.analysis.levels import OFTEN_N, left_in, too_wide
    from frictionloop.cli.recorded_units import asked
    from frictionloop.loop.metrics import out_of_reach as missed_of
    from frictionloop.loop.metrics import reach_of
    from frictionloop.loop.record import system_of
    from frictionloop.recordings.doubts import FINGERS_N

    system = system_of(run)
    misread = asked(system, "size", "signs")
    if asked(system, "size") or not mask.any():  # no reach explains what comes of that
        return misread
    (floor, top), r, d = reach_of(run, mask), run["f_r"].values[mask], run["d"].values[mask]
    missed = missed_of(run, mask)
    level = abs(float(d.mean()))
    if not missed.mean() >= (CLAMPED if left_in(system, level) else UNREACHED):
        return misread + split_error(run, mask, missed)
    low, high = float(np.median(floor + d)), float(np.median(top + d))
    had = f"{low:.3g} to {high:.3g} N could be had, as medians of what is scored"
    said = [*misread, f"The set-point is out of reach {missed.mean():.0%} of the time: {had}."]
    clamped = float(run["saturated"].values[mask].mean())
    if clamped > CLAMPED:
        said.append(f"So {clamped:.0%} of the commands are clamped.")
    for name, force in (("disturbance", level), ("setpoint", abs(float(r.mean())))):
        if force > FINGERS_N:
            return [*said, f"The {name} is {force:.3g} N on average; did you mean mN?"]
    around_0 = d - d.mean()
    without = (r < floor + around_0) | (r > top + around_0)
    if too_wide(float(np.std(d)), float(np.median(top - floor))):
        said.append(
            f"The disturbance varies by {np.std(d):.3g} N rms, more than vibration can make up for at any level."
        )
    elif level > OFTEN_N and not without.mean() >= UNREACHED:
        recorded = system.disturbance.kind == "recording" and left_in(system, level)
        mean = " --disturbance.remove_mean true" if recorded else ""
        hint = f"did you mean{mean or ' a disturbance around 0'}?"
        said.append(f"The disturbance has a mean of {d.mean():.3g} N, and the friction it adds to has its own; {hint}")
    elif np.median(r) > high:
        said.append(f"The finger's friction is too low for {np.median(r):.3g} N; did you mean a lower set-point?")
    else:
        said.append(f"No amplitude lowers it to {np.median(r):.3g} N; did you mean a higher set-point?")
    return said


def split_error(run: xr.Dataset, mask: np.ndarray, missed: np.ndarray) -> list[str]:
    """Return how much of the rms error lies where the set-point is out of reach, in a line; nothing if it seldom is.

    The two parts add up by their squares: rms^2 = beyond^2 + within^2, each over all that is scored.
    """
    share = float(missed.mean())
    if not MISSED < share < 1.0:
        return []
    square = (run["f_a"].values - run["f_r"].values)[mask] ** 2
    beyond, within = (float(np.sqrt(np.mean(square * there))) for there in (missed, ~missed))
    part = float(np.sum(square[missed]) / max(np.sum(square), TINY))
    said = f"The set-point is out of reach {share:.0%} of the time, where {part:.0%} of the squared error lies. "
    said += f"Of the rms error {1e3 * beyond:.3g} mN come from there, {1e3 * within:.3g} mN from within reach; their "
    said += "squares add up."
    return textwrap.wrap(said, WIDTH)


def at_ceiling(run: xr.Dataset, mask: np.ndarray, ceiling_um: float, largest_um: float) -> list[str]:
    """Return what a person is told of a force that stays high as the amplitude may not get larger; often nothing."""
    force = run["f_a" if "f_a" in run else "f_m"].values
    there = mask & (run["a"].values >= 0.99 * ceiling_um)
    above_n = float(np.nanmean((force - run["f_r"].values)[there])) if there.any() else 0.0
    share = there.sum() / max(mask.sum(), 1)
    if share < AT_CEILING or above_n < FAR_N:
        return []
    said = f"The amplitude is at its ceiling, {ceiling_um:.3g} um, {share:.0%} of the time, and the force is then "
    said += f"{1e3 * above_n:.3g} mN above the set-point. "
    if ceiling_um < largest_um:
        return textwrap.wrap(said + f"The ceiling may be why: the plate gives {largest_um:.3g} um.", WIDTH)
    return textwrap.wrap(said + "That is all the plate gives; did you mean a higher set-point?", WIDTH)
