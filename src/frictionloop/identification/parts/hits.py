"""Hits of a project: the resonance of the sensor, its Q, and the pole behind it where a hammer tells it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.identification.channels import rate_of
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.frequency_response import FrequencyResponse, response
from frictionloop.identification.hits import hits_of, pick_hits
from frictionloop.identification.long import Run
from frictionloop.identification.measured import Measured, measured
from frictionloop.identification.modes import Modes, modes
from frictionloop.identification.parts.part import POINTS, Found, Rows, Sensor, extra_modes, thin, with_method
from frictionloop.identification.project import Take
from frictionloop.identification.resonance import Resonance, fit_resonance

SAME = 0.05
"""Two modes closer than this share are one (assumed)."""
WORST_MISFIT = 0.2
"""Most of a frequency response that one resonance may leave unexplained (assumed)."""


def hits_part(take: Take, runs: Sequence[Run], sensor: Sensor, date: str) -> Found:
    """Return resonance and Q of the chosen mode, and the cutoff behind it where a hammer tells it."""
    runs = _grouped(runs)
    free = [modes(run, take.mode, take.band_hz, take.segment_s, take.exclude) for run in runs]
    picked = same_mode(free)
    chosen = [found.modes[k] for found, k in picked]
    rows: Rows = [("recording", "hit", "time (s)", "peak", "verdict")]
    names = take.files if len(runs) == len(take.files) else [str(k + 1) for k in range(len(runs))]
    for name, run in zip(names, runs, strict=True):
        table = [hit for _, found in hits_of(run, take.segment_s, take.exclude) for hit in found.table]
        rows += [(name, str(h.number), f"{h.time_s:.3f}", f"{h.peak:.3g}", h.reason or h.verdict) for h in table]
    told = [each.told for each in free]
    listed = [f"{m.frequency.value:.5g} Hz (Q {m.q.value:.3g}, {m.share:.0%} of the energy)" for m in free[0].modes]
    told.append(f"modes: {', '.join(listed)}; the {take.mode} one is taken for the sensor's resonance")
    if len(picked) < len(free):
        told.append(f"{len(free) - len(picked)} of {len(free)} recordings do not show that mode, and are left out")
    shift_hz = [found.method_hz[k] for found, k in picked]
    shift_q = [found.method_q[k] for found, k in picked]
    curves: dict[str, Any] = {"poles": [(p.order, p.frequency_hz, p.stable) for p in free[0].diagram]}
    curves["modes_hz"] = [m.frequency.value for m in free[0].modes]
    curves["decay"] = _drawn_decay(runs[0], take)
    how = f"free decay after {sum(f.hits for f in free)} hits, {take.mode} mode"
    extra: list[Measured] = []
    if all("hammer" in run.data_vars for run in runs):
        extra, fitted, shown = _hammered(take, runs, chosen[0].frequency.value, date)
        told.append(shown)
        if fitted is not None:
            pairs = list(zip(shift_hz, chosen, strict=True))
            shift_hz = [with_method(s, c.frequency.value - fitted[1].resonance.value) for s, c in pairs]
            shift_q = [with_method(s, c.q.value - fitted[1].q.value) for s, c in zip(shift_q, chosen, strict=True)]
            curves["response"] = _drawn_response(*fitted)
    values = [
        measured("sensor.resonance_hz", [m.frequency for m in chosen], shift_hz, how, take.files, date),
        measured("sensor.q", [m.q for m in chosen], shift_q, how, take.files, date),
        *extra,
        *extra_modes(take, free[0], how.partition(",")[0], date),
    ]
    return values, told, rows, curves


def same_mode(found: Sequence[Modes]) -> list[tuple[Modes, int]]:
    """Return the mode that is asked for in each recording that shows it: the one that half of them call so.

    Which mode is the lowest or the strongest may differ from hit to hit; one mode lies within 5 % of itself.
    """
    asked = sorted(each.asked[0].frequency.value for each in found)
    hertz = asked[(len(asked) - 1) // 2]
    picked = []
    for each in found:
        near = [k for k, mode in enumerate(each.modes) if abs(mode.frequency.value / hertz - 1) < SAME]
        if near:
            picked.append((each, min(near, key=lambda k: abs(each.modes[k].frequency.value - hertz))))
    return picked


def _grouped(runs: Sequence[Run]) -> list[Run]:
    """Return the recordings one by one; if some have one hit alone, all of them as one, one after the other."""
    whole = [run for run in runs if isinstance(run, xr.Dataset)]
    alone = len(whole) == len(runs) and any(pick_hits(run).good < 2 for run in whole)
    return [_joined(whole)] if alone else list(runs)


def _joined(runs: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return recordings of equal rate one after the other, each with its mean over the first tenth taken off."""
    level = [run - run.isel(time=slice(0, max(run.sizes["time"] // 10, 1))).mean() for run in runs]
    for new, old in zip(level, runs, strict=True):
        for name in new.data_vars:
            new[name].attrs.update(old[name].attrs)
    joined = xr.concat(level, "time", combine_attrs="override")
    step = float(runs[0]["time"][1] - runs[0]["time"][0])
    time = xr.Variable("time", np.arange(joined.sizes["time"]) * step, {"units": "s"})
    return joined.assign_coords(time=time)


def _hammered(
    take: Take, runs: Sequence[Run], near_hz: float, date: str
) -> tuple[list[Measured], tuple[FrequencyResponse, Resonance] | None, str]:
    """Return the pole behind the springs where the hammer's frequency response tells it."""
    found = response(runs, take.segment_s or _segment(runs), exclude=take.exclude)
    fit = fit_resonance(found, (0.2 * near_hz, min(2.5 * near_hz, 0.4 * found.rate_hz)))
    if fit.misfit > WORST_MISFIT:
        return [], None, f"one resonance leaves {fit.misfit:.0%} of the frequency response unexplained: it is not used"
    told = f"frequency response: resonance {fit.resonance}, Q {fit.q}, gain {fit.gain}"
    lag = fit.lag
    if not lag.value > 3 * lag.standard_error:
        return [], (found, fit), f"{told}; the pole behind it cannot be told ({lag})"
    cutoff = Estimate(fit.cutoff_hz, fit.cutoff_hz * lag.standard_error / lag.value, "Hz", lag.freedom)
    how = f"H1 of {found.hits} hits, {fit.band_hz[0]:.0f} to {fit.band_hz[1]:.0f} Hz"
    return [measured("sensor.cutoff_hz", [cutoff], [0.0], how, take.files, date)], (found, fit), told


def _segment(runs: Sequence[Run]) -> float:
    """Return the longest piece that every recording allows, in s."""
    return min(found.length / rate_of(run) for run, found in hits_of(runs))


def _drawn_decay(recording: Run, take: Take) -> dict[str, list[float]]:
    run, found = next(hits_of(recording, take.segment_s, take.exclude))
    start = found.starts[0] if found.starts else 0
    reading, time = run["f_m"].values, run["time"].values
    piece = reading[start : start + found.length]
    step = max(piece.size // (4 * POINTS), 1)
    return {
        "time_s": (time[: piece.size : step] - time[0]).tolist(),
        "reading": (piece[::step] - np.median(piece)).tolist(),
    }


def _drawn_response(found: FrequencyResponse, fit: Resonance) -> dict[str, list[float]]:
    inside = (found.frequency_hz > 0.5 * fit.band_hz[0]) & (found.frequency_hz < 1.5 * fit.band_hz[1])
    hertz, size = thin(found.frequency_hz[inside], np.abs(found.response[inside]))
    _, coherence = thin(found.frequency_hz[inside], found.coherence[inside])
    return {"frequency_hz": hertz, "magnitude": size, "coherence": coherence}
