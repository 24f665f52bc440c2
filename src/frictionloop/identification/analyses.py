"""One entry of a project analysed: measured values, sentences, and what the certificate draws, all as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.constants import g as STANDARD_GRAVITY

from frictionloop.identification.calibration import Calibration, weights
from frictionloop.identification.channel_map import ChannelMap
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.frequency_response import FrequencyResponse, response
from frictionloop.identification.hits import pick_hits
from frictionloop.identification.load import load
from frictionloop.identification.measured import Measured, measured
from frictionloop.identification.modes import modes
from frictionloop.identification.project import Take
from frictionloop.identification.quiet import Quiet, noise
from frictionloop.identification.resonance import Resonance, fit_resonance
from frictionloop.identification.slides import friction
from frictionloop.identification.straightness import straightness
from frictionloop.identification.takes import TAKES
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.whole import read_contents

HIDDEN = 1.5e-4
"""Relative error that a pulley on ball bearings leaves while a swinging hook hides its friction: b = 2.5e-4 of a
friction of 0.0015 (docs/calibration), over sqrt(3)."""
GRAVITY = 0.0015
"""The same of the standard gravity for that of an unknown place: 9.780 to 9.832 m/s^2, over sqrt(3)."""
REFERENCE_LOAD_N = 0.5
"""Load at which the preset's friction law has its f0 (``friction.reference_load_n``)."""
POINTS = 600
"""Points of a curve that is drawn."""
WORST_MISFIT = 0.2
"""Most of a frequency response that one resonance may leave unexplained (assumed)."""


@dataclass(frozen=True)
class Sensor:
    """What is known of the sensor when the next recording is analysed."""

    sensitivity: float = 1.0
    unit: str = "N"
    resonance_hz: float | None = None
    cutoff_hz: float | None = None
    cutoff_error_hz: float = 0.0


@dataclass(frozen=True)
class Part:
    """What one entry of the project told."""

    kind: str
    files: tuple[dict[str, str], ...]
    """path, sha256, date of each."""
    measured: tuple[Measured, ...]
    told: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    """A table, its first row the heading."""
    curves: dict[str, Any]
    """What is drawn."""


def analyse(take: Take, folder: Path, sensor: Sensor) -> Part:
    """Analyse the recordings of one entry.

    Raises
    ------
    FrictionloopError
        For what a file or an analysis refuses, naming the file.
    """
    by_file = [_loaded(folder / name, take, folder) for name in take.files]
    files = tuple(
        {"path": name, "sha256": runs[0].attrs["sha256"], "date": take.date or runs[0].attrs["date"]}
        for name, runs in zip(take.files, by_file, strict=True)
    )
    runs = [run for each in by_file for run in each]
    work = {"weights": _weights, "hits": _hits, "quiet": _quiet, "slides": _slides, **TAKES}[take.kind]
    try:
        values, told, rows, curves = work(take, runs, sensor, files[0]["date"])
    except FrictionloopError as refused:
        where = ", ".join(take.files) if len(take.files) < 4 else f"{take.files[0]} and {len(take.files) - 1} more"
        raise FrictionloopError(f"{where}: {refused}") from None
    told = list(dict.fromkeys([*(line for run in runs for line in run.attrs["told"].splitlines()), *told]))
    return Part(take.kind, files, tuple(values), tuple(told), tuple(rows), curves)


def _loaded(path: Path, take: Take, folder: Path) -> list[xr.Dataset]:
    """Return the recordings of a file: one, or one for each line of an array whose column is ``name[:, *]``."""
    chart = take.chart(folder)
    columns = [] if chart is None else [str(each.column) for each in chart.channels.values()]
    if chart is None or not any("*" in column for column in columns):
        return [load(path, chart, rate_hz=take.rate_hz)]
    there = {line.name for line in read_contents(path).channels}
    found: list[xr.Dataset] = []
    while all(column.replace("*", str(len(found))) in there for column in columns if "*" in column):
        tree = chart.model_dump()
        for each in tree["channels"].values():
            if "*" in str(each["column"]):
                each["column"] = each["column"].replace("*", str(len(found)))
        found.append(load(path, ChannelMap.from_tree(tree), rate_hz=take.rate_hz))
    return found or [load(path, chart, rate_hz=take.rate_hz)]


Rows = list[tuple[str, ...]]
Found = tuple[list[Measured], list[str], Rows, dict[str, Any]]


def _weights(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor, date: str) -> Found:
    gravity = take.gravity_m_s2 or STANDARD_GRAVITY
    lines = [weights(run, take.settle_s, gravity, take.tolerance) for run in runs]
    straight = [straightness(line) for line in lines]
    methods = []
    for line, left in zip(lines, straight, strict=True):
        bent = abs(left.curvature.value) if left.curved else 0.0
        apart = 0.0 if left.friction is None else abs(left.friction.sensitivity.value - line.sensitivity.value)
        shares = [bent, line.weights_error, _swing(line), HIDDEN, 0.0 if take.gravity_m_s2 else GRAVITY]
        share = float(np.linalg.norm(shares))
        methods.append(float(np.hypot(share * abs(line.sensitivity.value), apart / np.sqrt(3))))
    slopes = [_safer(line) for line in lines]
    count = sum(line.steps.mass_kg.size for line in lines)
    how = f"line through {count} weights"
    offsets = [line.offset for line in lines]
    values = [
        measured("sensitivity", slopes, methods, how, take.files, date),
        measured("offset", offsets, [0.0] * len(lines), how, take.files, date),
    ]
    first = lines[0]
    rows: Rows = [("mass (g)", f"reading ({first.steps.unit})", "residual (mN)")]
    for line in lines:
        parts = zip(line.steps.mass_kg, line.steps.reading, line.residuals_n, strict=True)
        rows += [(f"{1e3 * m:.4g}", f"{y:.6g}", f"{1e3 * r:+.3g}") for m, y, r in parts]
    told = [f"R2 = {line.r2:.6f}, residual {1e3 * line.residual_rms_n:.2g} mN rms" for line in lines]
    told += [f"hysteresis {100 * line.hysteresis:.2g} % of the span" for line in lines if np.isfinite(line.hysteresis)]
    told += [each for left in straight for each in left.told]
    if not take.gravity_m_s2:
        told.append("gravity_m_s2 is not stated: the standard value may be off by 0.3 %, which is most of the interval")
    curves: dict[str, Any] = {
        "unit": first.steps.unit,
        "force_n": [(line.steps.mass_kg * gravity).tolist() for line in lines],
        "reading": [line.steps.reading.tolist() for line in lines],
        "residual_n": [line.residuals_n.tolist() for line in lines],
        "slope": values[0].value,
        "offset": values[1].value,
    }
    return values, told, rows, curves


def _swing(line: Calibration) -> float:
    """Return the relative error that hooks which still swing leave in the sensitivity.

    A swing of phi changes the tension by (phi^2/4)(1 - 3 cos 2wt): what does not average out is 0.47 of the standard
    deviation of what does.
    """
    force = np.abs(line.steps.reading - line.offset.value)
    heavy = force > 0.5 * force.max()
    return 0.47 * float(np.sqrt(np.mean((line.steps.moves[heavy] / force[heavy]) ** 2)))


def _safer(line: Calibration) -> Estimate:
    """Return the sensitivity with the larger error of scatter and, with fewer than 12 steps, of leaving one out."""
    few = line.steps.mass_kg.size < 12
    return max(line.sensitivity, line.left_out, key=lambda e: e.standard_error) if few else line.sensitivity


def _hits(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor, date: str) -> Found:
    runs = _grouped(runs)
    free = [modes(run, take.mode, take.band_hz, take.segment_s, take.exclude) for run in runs]
    chosen = [found.asked[0] for found in free]
    rows: Rows = [("recording", "hit", "time (s)", "peak", "verdict")]
    names = take.files if len(runs) == len(take.files) else [str(k + 1) for k in range(len(runs))]
    for name, run in zip(names, runs, strict=True):
        table = pick_hits(run, take.segment_s, take.exclude).table
        rows += [(name, str(h.number), f"{h.time_s:.3f}", f"{h.peak:.3g}", h.reason or h.verdict) for h in table]
    told = [each.told for each in free]
    listed = [f"{m.frequency.value:.5g} Hz (Q {m.q.value:.3g}, {m.share:.0%} of the energy)" for m in free[0].modes]
    told.append(f"modes: {', '.join(listed)}; the {take.mode} one is taken for the sensor's resonance")
    k = [found.chosen[0] for found in free]
    shift_hz = [found.method_hz[i] for found, i in zip(free, k, strict=True)]
    shift_q = [found.method_q[i] for found, i in zip(free, k, strict=True)]
    curves: dict[str, Any] = {"poles": [(p.order, p.frequency_hz, p.stable) for p in free[0].diagram]}
    curves["modes_hz"] = [m.frequency.value for m in free[0].modes]
    curves["decay"] = _drawn_decay(runs[0], take)
    how = f"free decay after {sum(f.hits for f in free)} hits, {take.mode} mode"
    extra: list[Measured] = []
    if all("hammer" in run for run in runs):
        extra, fitted, shown = _hammered(take, runs, chosen[0].frequency.value, date)
        told.append(shown)
        if fitted is not None:
            pairs = list(zip(shift_hz, chosen, strict=True))
            shift_hz = [_with(s, c.frequency.value - fitted[1].resonance.value) for s, c in pairs]
            shift_q = [_with(s, c.q.value - fitted[1].q.value) for s, c in zip(shift_q, chosen, strict=True)]
            curves["response"] = _drawn_response(*fitted)
    values = [
        measured("sensor.resonance_hz", [m.frequency for m in chosen], shift_hz, how, take.files, date),
        measured("sensor.q", [m.q for m in chosen], shift_q, how, take.files, date),
        *extra,
    ]
    return values, told, rows, curves


def _with(error: float, apart: float) -> float:
    """Return the error of a method whose value is so far from another method's."""
    return float(np.hypot(error, apart / np.sqrt(3)))


def _grouped(runs: Sequence[xr.Dataset]) -> list[xr.Dataset]:
    """Return the recordings one by one; if some have one hit alone, all of them as one, one after the other."""
    many = [run for run in runs if pick_hits(run).good >= 2]
    return list(runs) if len(many) == len(runs) else [_joined(runs)]


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
    take: Take, runs: Sequence[xr.Dataset], near_hz: float, date: str
) -> tuple[list[Measured], tuple[FrequencyResponse, Resonance] | None, str]:
    """Return the pole behind the springs where the hammer's frequency response tells it."""
    found = response(list(runs), take.segment_s or _segment(runs), exclude=take.exclude)
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


def _segment(runs: Sequence[xr.Dataset]) -> float:
    """Return the longest piece that every recording allows, in s."""
    steps = [float(run["time"][1] - run["time"][0]) for run in runs]
    return min(pick_hits(run).length * step for run, step in zip(runs, steps, strict=True))


def _quiet(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor, date: str) -> Found:
    def at(cutoff_hz: float | None) -> list[Quiet]:
        return [noise(run, take.interval_s, sensor.sensitivity, sensor.resonance_hz, cutoff_hz) for run in runs]

    found = at(sensor.cutoff_hz)
    off = at(sensor.cutoff_hz + sensor.cutoff_error_hz) if sensor.cutoff_hz else found
    shifts = [
        _with(moved.density.value - each.density.value, each.other_density_n_rthz - each.density.value)
        for each, moved in zip(found, off, strict=True)
    ]
    first = found[0]
    (low, high), (start, stop) = first.band_hz, first.interval_s
    how = f"mean density from {low:.0f} to {high:.0f} Hz, {start:.1f} to {stop:.1f} s"
    value = measured("sensor.noise_density_n_rthz", [each.density for each in found], shifts, how, take.files, date)
    rows: Rows = [("band", "rms (N)"), *((band, f"{rms:.3g}") for band, rms in first.rms_n.items())]
    told = [each for one in found for each in one.told]
    if first.step_n:
        counts = value.value / first.step_n
        told.append(f"the converter's step is {first.step_n:.3g} N; the density is {counts:.3g} counts/rtHz")
    hertz, density = _thin(first.spectrum.frequency_hz, first.spectrum.density)
    curves: dict[str, Any] = {"frequency_hz": hertz, "density": density, "band_hz": first.band_hz, "level": value.value}
    return [value], told, rows, curves


def _slides(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor, date: str) -> Found:
    """Return f0 at the load of the preset's law, from slides without vibration."""
    newtons = {"units": "N"}
    found = [friction(run.assign(f_m=(run["f_m"] / sensor.sensitivity).assign_attrs(newtons))) for run in runs]
    levels = []
    for each in found:
        level = each.level_n(REFERENCE_LOAD_N)
        share = each.mu.standard_error / each.mu.value
        levels.append(Estimate(level, share * level, "N", each.mu.freedom))
    loads = [slide.load_n for each in found for slide in each.slides]
    spread = 0.2 if not np.isfinite(found[0].exponent.value) else found[0].exponent.standard_error
    off = [abs(float(spread * np.log(REFERENCE_LOAD_N / np.mean(loads)))) * level.value for level in levels]
    how = f"{len(loads)} slides, at a load of {REFERENCE_LOAD_N:g} N"
    value = measured("friction.nominal_n", levels, off, how, take.files, date)
    rows: Rows = [("from (s)", "to (s)", "speed (mm/s)", "load (N)", "friction (N)", "mu", "spectrum, two ways")]
    for s in (slide for each in found for slide in each.slides):
        numbers = (f"{s.start_s:.2f}", f"{s.stop_s:.2f}", f"{1e3 * s.speed_m_s:.1f}", f"{s.load_n:.3f}")
        rows.append((*numbers, f"{s.friction_n:.3f}", f"{s.mu:.3f}", f"{s.slope_welch:.2f}, {s.slope_whittle:.2f}"))
    curves: dict[str, Any] = {}
    if take.finger is not None:
        entries = [{"friction.nominal_n": [float(np.log(e.value)), e.standard_error / e.value]} for e in levels]
        curves["person"] = {"finger": take.finger, "found": entries}
    return [value], [line for each in found for line in each.told], rows, curves


def _drawn_decay(run: xr.Dataset, take: Take) -> dict[str, list[float]]:
    found = pick_hits(run, take.segment_s, take.exclude)
    start = found.starts[0] if found.starts else 0
    reading, time = run["f_m"].values, run["time"].values
    piece = reading[start : start + found.length]
    step = max(piece.size // (4 * POINTS), 1)
    return {"time_s": (time[: piece.size : step]).tolist(), "reading": (piece[::step] - np.median(piece)).tolist()}


def _drawn_response(found: FrequencyResponse, fit: Resonance) -> dict[str, list[float]]:
    inside = (found.frequency_hz > 0.5 * fit.band_hz[0]) & (found.frequency_hz < 1.5 * fit.band_hz[1])
    hertz, size = _thin(found.frequency_hz[inside], np.abs(found.response[inside]))
    _, coherence = _thin(found.frequency_hz[inside], found.coherence[inside])
    return {"frequency_hz": hertz, "magnitude": size, "coherence": coherence}


def _thin(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[list[float], list[float]]:
    """Return a curve by at most so many points, evenly on a logarithmic axis."""
    if x.size <= POINTS:
        return x.tolist(), y.tolist()
    rows = np.unique(np.searchsorted(x, np.geomspace(x[0], x[-1], POINTS)).clip(0, x.size - 1))
    return x[rows].tolist(), y[rows].tolist()
