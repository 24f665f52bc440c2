"""Slides of a finger in a long record: where they are, friction over load."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.signal import savgol_filter
from scipy.stats import linregress

from frictionloop.findings import Condition, Finding
from frictionloop.identification.estimate import Estimate, measured
from frictionloop.identification.hit_onsets import quiet_noise
from frictionloop.identification.project_entry_result import EntryResult, Rows, Sensor, in_newtons, not_told, off_line
from frictionloop.identification.project_file import Take
from frictionloop.identification.recording_columns import READING, channel, rate_of, runs_of
from frictionloop.identification.susceptibility_fit import REFERENCE_LOAD_N
from frictionloop.quantities import Array, must_be

TOUCHING = 0.2
"""Share of the usual load above which a finger touches (assumed)."""
FASTEST_M_S = 2.0
"""A finger does not slide faster than this (assumed); a position in mm that is taken for m does."""
JUMP = 0.25
"""A step of the position by more than this share of all its way is a jump (assumed)."""
CHANGES = 0.1
"""Change of friction over load within a slide that is told (assumed)."""
LIFTED = 0.4
"""A load that falls below this share of the usual one is that of a finger which has lifted (assumed)."""
SMOOTH_S = 0.05
"""Time over which a position is turned into a speed, and a load is judged (assumed)."""
STEADY = 0.3
"""A finger slides where its speed is within this share of the median of the slide (assumed)."""
SLOWEST_M_S = 2e-3
SHORTEST_S = 0.3
LEAST_LOADS = 0.1
"""Relative spread of the load below which its exponent cannot be told (assumed)."""


class Slide(NamedTuple):
    """One slide."""

    start_s: float
    stop_s: float
    speed_m_s: float
    """With its sign."""
    friction_n: float
    """Mean, positive against the motion."""
    load_n: float
    mu: float
    mu_change: float
    """Of the last third over that of the first."""


@dataclass(frozen=True)
class Friction:
    """What slides tell of a finger."""

    slides: tuple[Slide, ...]
    mu: Estimate
    """Mean over slides; with two or more its error is their scatter."""
    exponent: Estimate
    """n of friction ~ load^n over all slides; NaN for fewer than four or loads that hardly differ."""
    findings: tuple[Finding, ...]

    def level_n(self, load_n: float) -> float:
        """Return the friction at a load, mu N (load/N)^n about the mean load N of the slides, n = 1 if not known."""
        usual = float(np.mean([slide.load_n for slide in self.slides]))
        exponent = self.exponent.value if math.isfinite(self.exponent.value) else 1.0
        return self.mu.value * usual * (load_n / usual) ** exponent


def friction(recording: xr.Dataset) -> Friction:
    """Return friction from slides without vibration, found by speed and load.

    The zeros of friction and load are those of the stretches without contact, joined by straight lines.

    Parameters
    ----------
    recording : xarray.Dataset
        Columns ``f_m`` and ``load`` in N, and ``position`` in m or ``speed`` in m/s, over ``time`` in s.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, no slide, or friction that rises with an ``amplitude`` beside
        it, as electroadhesion does.
    """
    force, load, rate_hz = channel(recording, READING, ("N",)), channel(recording, "load", ("N",)), rate_of(recording)
    window = max(int(SMOOTH_S * rate_hz) // 2 * 2 + 1, 5)
    if "speed" in recording:
        speed = channel(recording, "speed", ("m/s",))
    else:
        position = channel(recording, "position", ("m",))
        speed = np.asarray(savgol_filter(position, window, 2, deriv=1, delta=1 / rate_hz))
    smooth = np.convolve(load - np.median(load), np.ones(window) / window, mode="same") + np.median(load)
    low, usual = float(np.percentile(smooth, 2)), float(np.percentile(smooth, 95))
    lifted = low < LIFTED * usual
    touching = smooth > low + TOUCHING * (usual - low) if lifted else np.ones(force.size, dtype=bool)
    if lifted:
        force, load = (without_zero(each, ~touching, window) for each in (force, load))
    began_s = float(recording["time"][0])
    found = [_slide(force, load, speed, a, b, rate_hz, began_s) for a, b in slide_rows(touching, speed, rate_hz)]
    if not found:
        raise must_be("recording: slides", 0, f"1 of {SHORTEST_S:g} s, {1e3 * SLOWEST_M_S:g} mm/s")
    refuse_electroadhesion(recording, force)
    mus = np.array([slide.mu for slide in found])
    scatter = float(mus.std(ddof=1) / math.sqrt(mus.size)) if mus.size > 1 else abs(found[0].mu_change - 1) * mus[0] / 3
    mu = Estimate(float(mus.mean()), scatter, "", max(mus.size - 1.0, 1.0))
    return Friction(tuple(found), mu, _exponent(found), tuple(_doubts(recording, found, lifted)))


def _doubts(recording: xr.Dataset, found: Sequence[Slide], lifted: bool) -> Iterator[Finding]:
    where = Condition(channel="position")
    if "position" in recording and "speed" not in recording:
        steps = np.abs(np.diff(recording["position"].values))
        jumps = int(np.count_nonzero(steps > JUMP * float(np.ptp(recording["position"].values))))
        if jumps:
            at_s = float(recording["time"][int(np.argmax(steps))])
            yield Finding("COUNTER-WRAPS", value=jumps, where=where, remedy="wrap in the map", more={"at_s": at_s})
    fastest = max(abs(slide.speed_m_s) for slide in found)
    if fastest > FASTEST_M_S:
        more = {"path": "speed", "low": SLOWEST_M_S, "high": FASTEST_M_S}
        yield Finding("UNIT-DOUBT", value=fastest, unit="m/s", where=where, remedy="unit = mm", more=more)
    change = max((slide.mu_change - 1 for slide in found), key=abs)
    if abs(change) > CHANGES:
        yield off_line("mu, change within a slide", 100 * change, "%", "f_m")
    if not lifted:
        yield not_told("zeros of friction and load", "the finger never lifts")


def _slide(force: Array, load: Array, speed: Array, a: int, b: int, rate_hz: float, began_s: float) -> Slide:
    mean = float(force[a:b].mean())
    # Whichever way the sensor counts: friction opposes the motion, so its mean over a slide is positive.
    against = force * (1.0 if mean > 0 else -1.0)
    f, n = against[a:b], load[a:b]
    third = (b - a) // 3
    ratios = [float(f[part].mean() / n[part].mean()) for part in (slice(0, third), slice(-third, None))]
    return Slide(
        start_s=began_s + a / rate_hz,
        stop_s=began_s + b / rate_hz,
        speed_m_s=float(speed[a:b].mean()),
        friction_n=float(f.mean()),
        load_n=float(n.mean()),
        mu=float(f.mean() / n.mean()),
        mu_change=ratios[1] / ratios[0],
    )


def _exponent(slides: Sequence[Slide]) -> Estimate:
    loads = np.array([slide.load_n for slide in slides])
    if loads.size < 4 or loads.std() < LEAST_LOADS * loads.mean():
        return Estimate(math.nan, math.inf, "", 1.0)
    line = linregress(np.log(loads), np.log([slide.friction_n for slide in slides]))
    return Estimate(float(line.slope), float(line.stderr), "", loads.size - 2.0)


def without_zero(values: Array, free: NDArray[np.bool_], margin: int) -> Array:
    """Return a channel less the line through the medians of the stretches without contact."""
    inner = [(a + margin, b - margin) for a, b in runs_of(free) if b - a > 4 * margin]
    if not inner:
        return values
    centres = [(a + b) / 2 for a, b in inner]
    return np.asarray(values - np.interp(np.arange(values.size), centres, [np.median(values[a:b]) for a, b in inner]))


def slide_rows(touching: NDArray[np.bool_], speed: Array, rate_hz: float) -> list[tuple[int, int]]:
    """Return rows between which a finger touches and slides evenly."""
    least = max(SLOWEST_M_S, 5 * quiet_noise(speed))
    moving = touching & (np.abs(speed) > least)
    signed = np.where(moving, np.sign(speed), 0.0)
    edges = np.flatnonzero(np.diff(np.concatenate([[0.0], signed, [0.0]])))
    runs = []
    for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        if signed[a] == 0 or (b - a) < SHORTEST_S * rate_hz:
            continue
        usual = float(np.median(np.abs(speed[a:b])))
        even = np.flatnonzero(np.abs(np.abs(speed[a:b]) - usual) < STEADY * usual)
        first, stop = a + int(even[0]), a + int(even[-1]) + 1
        if stop - first >= SHORTEST_S * rate_hz:
            runs.append((first, stop))
    return runs


def refuse_electroadhesion(recording: xr.Dataset, force: Array) -> None:
    """Refuse a recording whose friction rises with its ``amplitude``."""
    if "amplitude" not in recording:
        return
    amplitude = np.abs(np.asarray(recording["amplitude"].values, dtype=float))
    if np.ptp(amplitude) > 0 and float(np.corrcoef(amplitude, np.abs(force))[0, 1]) > 0.5:
        raise must_be("recording: friction", "rising with 'amplitude'", "falling: electroadhesion raises it")


def slides_entry(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor) -> EntryResult:
    """Return f0 at the load of the preset's law, from slides without vibration."""
    if take.interval_s is not None:
        runs = [run.sel(time=slice(*take.interval_s)) for run in runs]
    scaled, doubts = in_newtons(runs, sensor)
    found = [friction(run) for run in scaled]
    levels = []
    for each in found:
        level = each.level_n(REFERENCE_LOAD_N)
        share = each.mu.standard_error / each.mu.value
        levels.append(Estimate(level, share * level, "N", each.mu.freedom))
    every = [slide for each in found for slide in each.slides]
    loads = [slide.load_n for slide in every]
    spread = 0.2 if not np.isfinite(found[0].exponent.value) else found[0].exponent.standard_error
    off = [abs(float(spread * np.log(REFERENCE_LOAD_N / np.mean(loads)))) * level.value for level in levels]
    how = f"slides, {len(loads)}, at {REFERENCE_LOAD_N:g} N"
    value = measured("friction.nominal_n", levels, off, how)
    rows: Rows = [("from (s)", "to (s)", "speed (mm/s)", "load (N)", "friction (N)", "mu")]
    for s in every:
        row = (f"{s.start_s:.2f}", f"{s.stop_s:.2f}", f"{1e3 * s.speed_m_s:.1f}", f"{s.load_n:.3f}")
        rows.append((*row, f"{s.friction_n:.3f}", f"{s.mu:.3f}"))
    slides = found[0].slides
    drawn = {name: [getattr(slide, name) for slide in slides] for name in ("start_s", "load_n", "friction_n")}
    curves: dict[str, Any] = {"slides": {**drawn, "ratio": [slide.mu for slide in slides], "mu": found[0].mu.value}}
    if take.finger is not None:
        entries = [{"friction.nominal_n": [float(np.log(e.value)), e.standard_error / e.value]} for e in levels]
        curves["person"] = {"finger": take.finger, "found": entries}
    numbers: dict[str, Any] = {"mu": found[0].mu, "speeds_mm_s": [1e3 * s.speed_m_s for s in every]}
    numbers |= {"slides": len(every), "seconds": sum(s.stop_s - s.start_s for s in every)}
    numbers["mu_change_percent"] = [100 * (s.mu_change - 1) for s in every]
    doubts += [each for one in found for each in one.findings]
    return EntryResult([value], doubts, numbers, rows, curves)
