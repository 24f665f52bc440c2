"""Slides of a finger in a long record: where they are, friction over load, how it falls off over frequency."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.signal import savgol_filter
from scipy.stats import linregress

from frictionloop.findings import Condition, Finding
from frictionloop.identification.measured import Estimate
from frictionloop.identification.part import not_told, off_line
from frictionloop.identification.recording_columns import READING, channel, rate_of
from frictionloop.identification.slide_rows import (
    SHORTEST_S,
    SLOWEST_M_S,
    SMOOTH_S,
    load_exponent,
    refuse_electroadhesion,
    slide_rows,
    tremor,
    welch_slope,
    whittle_slope,
    without_zero,
)
from frictionloop.quantities import must_be

Array = NDArray[np.float64]
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
    exponent: Estimate
    """n of friction ~ load^n within the slide; NaN where the load hardly changes."""
    slope_welch: float
    """Exponent of the power spectrum from 5 to 100 Hz, by a line through Welch's."""
    slope_whittle: float
    """The same by Whittle's likelihood of the periodogram."""
    tremor_n: float
    """rms of the friction from 6 to 14 Hz."""
    onset: float
    """Largest friction in the 0.2 s before the slide over its mean: stick before slip."""


@dataclass(frozen=True)
class Friction:
    """What slides tell of a finger."""

    slides: tuple[Slide, ...]
    mu: Estimate
    """Mean over slides; with two or more its error is their scatter."""
    exponent: Estimate
    """Of the load, over all slides."""
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
    found = [_slide(force, load, speed, a, b, rate_hz) for a, b in slide_rows(touching, speed, rate_hz)]
    if not found:
        accepted = f"1 or more of {SHORTEST_S:g} s, even, above {1e3 * SLOWEST_M_S:g} mm/s"
        raise must_be("recording: slides", 0, accepted)
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


def _slide(force: Array, load: Array, speed: Array, a: int, b: int, rate_hz: float) -> Slide:
    mean = float(force[a:b].mean())
    # Whichever way the sensor counts: friction opposes the motion, so its mean over a slide is positive.
    against = force * (1.0 if mean > 0 else -1.0)
    f, n = against[a:b], load[a:b]
    third = (b - a) // 3
    ratios = [float(f[part].mean() / n[part].mean()) for part in (slice(0, third), slice(-third, None))]
    before = against[max(a - int(0.2 * rate_hz), 0) : a]
    return Slide(
        start_s=a / rate_hz,
        stop_s=b / rate_hz,
        speed_m_s=float(speed[a:b].mean()),
        friction_n=float(f.mean()),
        load_n=float(n.mean()),
        mu=float(f.mean() / n.mean()),
        mu_change=ratios[1] / ratios[0],
        exponent=load_exponent(f, n, rate_hz),
        slope_welch=welch_slope(f, rate_hz),
        slope_whittle=whittle_slope(f, rate_hz),
        tremor_n=tremor(f, rate_hz),
        onset=float(before.max() / f.mean()) if before.size else math.nan,
    )


def _exponent(slides: Sequence[Slide]) -> Estimate:
    """Return the exponent over slides of different loads, or that within the slide with the least error."""
    loads = np.array([slide.load_n for slide in slides])
    if loads.size >= 4 and loads.std() > 0.1 * loads.mean():
        line = linregress(np.log(loads), np.log([slide.friction_n for slide in slides]))
        return Estimate(float(line.slope), float(line.stderr), "", loads.size - 2.0)
    return min((slide.exponent for slide in slides), key=lambda each: each.standard_error)
