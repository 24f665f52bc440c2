"""What is measured of the plate and of its loop: resonance, envelope, amplitude scale, carrier, delay."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.identification.loop_delay import loop_delay
from frictionloop.identification.measured import measured
from frictionloop.identification.part import Rows, Sensor, Told, not_told
from frictionloop.identification.plate_decay import plate_decay, plate_envelope
from frictionloop.identification.plate_sweep import PlateResonance, plate_sweep, stepped
from frictionloop.identification.project import Take
from frictionloop.identification.recording_columns import channel
from frictionloop.identification.straight_scale import POINTS, carrier_drift, straight_scale
from frictionloop.quantities import must_be

CORNER = "controller.model.plate_hz"
BEYOND = 1.05
"""Drives beyond so many times the largest measured are said to be continued to (assumed)."""


def plate_told(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor, date: str) -> Told:
    """Return resonance, Q and corner of the envelope from stepped sines, decays or rises, or envelopes."""
    if all("envelope" in run for run in runs):
        return _envelope(take, runs, date)
    runs = [stepped(run) if "frequency" in run and "time" in run.dims else run for run in runs]
    found = [plate_sweep(run) if "frequency" in run else plate_decay(run) for run in runs]
    how = found[0].how + (f", {len(found)} recordings" if len(found) > 1 else "")
    hertz, q, corner = zip(*((f.method_hz, f.method_q, f.method_corner_hz) for f in found), strict=True)
    values = [
        measured("plate.frequency_hz", [f.resonance for f in found], hertz, how, take.files, date),
        measured("plate.q", [f.q for f in found], q, how, take.files, date),
        measured(CORNER, [f.corner for f in found], corner, how, take.files, date),
    ]
    rows: Rows = [("recording", "resonance", "Q", "corner of the envelope", "left")]
    rows += [
        (name, f"{f.resonance}", f"{f.q}", f"{f.corner}", f"{f.misfit:.1%}")
        for name, f in zip(take.files, found, strict=False)
    ]
    drawn = "sweep" if "frequency" in runs[0] else "decay"
    numbers: dict[str, Any] = {"misfit_percent": [100 * f.misfit for f in found]}
    downs = [f.down_hz for f in found if f.down_hz is not None]
    numbers |= {"down_less_up_hz": downs} if downs else {}
    return Told(values, [each for f in found for each in f.findings], numbers, rows, {drawn: _drawn(found[0], runs[0])})


def _drawn(found: PlateResonance, run: xr.Dataset) -> dict[str, Any]:
    step = max(found.x.size // (4 * POINTS), 1)
    curves = {name: np.asarray(getattr(found, name))[::step].tolist() for name in ("x", "y", "fitted")}
    return curves | {"unit": run["vibration"].attrs["units"]}


def _envelope(take: Take, runs: Sequence[xr.Dataset], date: str) -> Told:
    found = [plate_envelope(run) for run in runs]
    how = f"{sum(f.jumps for f in found)} falls or rises of the envelope"
    value = measured(CORNER, [f.corner for f in found], [f.method_hz for f in found], how, take.files, date)
    rows: Rows = [
        ("recording", "corner", "left"),
        *((n, f"{f.corner}", f"{f.misfit:.1%}") for n, f in zip(take.files, found, strict=False)),
    ]
    first = found[0]
    step = max(first.time_s.size // POINTS, 1)
    drawn = {"x": first.time_s, "y": first.y, "fitted": first.fitted}
    curves: dict[str, Any] = {name: each[::step].tolist() for name, each in drawn.items()}
    curves["unit"] = runs[0]["envelope"].attrs["units"]
    return Told([value], [], {"misfit_percent": [100 * f.misfit for f in found]}, rows, {"envelope": curves})


def scale_told(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor, date: str) -> Told:
    """Return the amplitude in um per drive, and the largest one, from drives under a vibrometer."""
    pairs = [_pairs(run, take.frequency_hz) for run in runs]
    lines = [straight_scale(drive, amplitude, f"um/{unit or 'duty'}") for drive, amplitude, unit in pairs]
    how = f"line through {sum(line.x.size for line in lines)} drives"
    slopes, methods = [line.slope for line in lines], [line.method for line in lines]
    values = [measured("amplitude_scale", slopes, methods, how, take.files, date)]
    found = []
    if take.full_drive is not None:
        full, path = take.full_drive, "plate.max_amplitude_um"
        ends = [line.at(full, "um") for line in lines]
        values.append(measured(path, ends, [full * each for each in methods], f"{how}, at {full:g}", take.files, date))
        largest = max(float(line.x.max()) for line in lines)
        if full > BEYOND * largest:
            found = [not_told(f"{path} at {full:g}", f"measured to {largest:g}")]
    unit = pairs[0][2]
    rows: Rows = [("drive", "amplitude (um)", "residual (um)")]
    for line in lines:
        left = line.y - line.offset.value - line.slope.value * line.x
        rows += [(f"{x:.4g}", f"{y:.4g}", f"{r:+.2g}") for x, y, r in zip(line.x, line.y, left, strict=True)]
    numbers = {"r2": [line.r2 for line in lines], "upper_less_lower_half_percent": [100 * line.bend for line in lines]}
    curves = lines[0].drawn(f"drive ({unit or 'duty'})", "amplitude (µm)")
    return Told(values, found, numbers, rows[:200], {"pairs": curves})


def _pairs(run: xr.Dataset, frequency_hz: float | None) -> tuple[NDArray[np.float64], NDArray[np.float64], str]:
    dim = "row" if "row" in run.dims else "time"
    drive = channel(run, "drive", ("V", "", "counts"), dim=dim)
    if "vibration" in run and run["vibration"].attrs.get("units") == "m/s":
        if frequency_hz is None:
            raise must_be("frequency_hz", None, "given where the vibration is in m/s", "Hz")
        amplitude = 1e6 * channel(run, "vibration", ("m/s",), dim=dim) / (2 * math.pi * frequency_hz)
    else:
        amplitude = channel(run, "vibration", ("um",), dim=dim)
    if dim == "row":
        return drive, np.abs(amplitude), str(run["drive"].attrs["units"])
    # Over time: the mean of each level once it is still, its second half.
    edges = np.concatenate([[0], np.flatnonzero(np.diff(drive)) + 1, [drive.size]])
    levels = [(a + (b - a) // 2, b) for a, b in pairwise(edges.tolist()) if b - a >= 4]
    drives = np.array([drive[b - 1] for _, b in levels])
    means = np.array([float(np.abs(amplitude[a:b]).mean()) for a, b in levels])
    return drives, means, str(run["drive"].attrs["units"])


def carrier_told(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor, date: str) -> Told:
    """Return how fast the resonance drifts."""
    found = [carrier_drift(run) for run in runs]
    how = f"line through {found[0].frequency_hz.size} resonances"
    methods = [f.method_hz_per_min for f in found]
    values = [measured("carrier_drift", [f.rate for f in found], methods, how, take.files, date)]
    slopes = [f.per_kelvin for f in found if f.per_kelvin is not None]
    if slopes:
        values.append(measured("carrier_drift_per_kelvin", slopes, [0.0] * len(slopes), how, take.files, date))
    rows: Rows = [("recording", "drift", "largest less least")]
    rows += [(name, f"{f.rate}", f"{f.span_hz:.3g} Hz") for name, f in zip(take.files, found, strict=False)]
    first = found[0]
    middle = float(first.frequency_hz.mean())
    numbers: dict[str, Any] = {"largest_less_least_hz": [f.span_hz for f in found]}
    for q in (150, 300):
        numbers[f"lost_at_q_{q}_percent"] = [100 * (1 - f.share_left(middle, q)) for f in found]
    step = max(first.time_s.size // POINTS, 1)
    curves = {
        "x": (first.time_s[::step] / 60).tolist(),
        "y": (first.frequency_hz[::step] - middle).tolist(),
        "middle": middle,
    }
    return Told(values, [], numbers, rows, {"drift": curves})


def delay_told(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor, date: str) -> Told:
    """Return the delay of the loop from known jumps."""
    if take.control_hz is None:
        raise must_be("control_hz", None, "given: the control rate", "Hz")
    found = [loop_delay(run, take.control_hz, waits=take.waits) for run in runs]
    how = f"{sum(f.jumps for f in found)} jumps" + ", less half a period" * take.waits
    value = measured("controller.delay_s", [f.delay for f in found], [f.method_s for f in found], how, take.files, date)
    rows: Rows = [("recording", "delay", "jump to answer", "scatter of jumps")]
    rows += [
        (n, f"{f.delay}", f"{f.whole}", f"{1e6 * f.spread_s:.0f} us") for n, f in zip(take.files, found, strict=False)
    ]
    first = found[0]
    numbers = {"jumps": [f.jumps for f in found], "scatter_us": [1e6 * f.spread_s for f in found]}
    curves = {"x": first.time_s.tolist(), "y": first.answer.tolist(), "fitted": first.fitted.tolist()}
    return Told([value], [each for f in found for each in f.findings], numbers, rows, {"answer": curves})
