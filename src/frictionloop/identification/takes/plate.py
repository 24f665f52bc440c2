"""What is measured of the plate and of its loop: resonance, envelope, amplitude scale, carrier, delay."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.identification.carrier_drift import carrier_drift
from frictionloop.identification.channels import channel
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.loop_delay import loop_delay
from frictionloop.identification.measured import Measured, measured
from frictionloop.identification.plate_decay import plate_decay
from frictionloop.identification.plate_envelope import plate_envelope
from frictionloop.identification.plate_sweep import PlateResonance, plate_sweep
from frictionloop.identification.stepped import stepped
from frictionloop.identification.straight_scale import straight_scale
from frictionloop.quantities import FrictionloopError

Found = tuple[list[Measured], list[str], list[tuple[str, ...]], dict[str, Any]]
POINTS = 800
CORNER = "controller.model.plate_hz"


def plate(take: Any, runs: Sequence[xr.Dataset], sensor: Any, date: str) -> Found:
    """Return resonance, Q and corner of the envelope from stepped sines, decays or rises, or envelopes."""
    if all("envelope" in run for run in runs):
        return _envelope(take, runs, date)
    runs = [stepped(run) if "frequency" in run and "time" in run.dims else run for run in runs]
    found = [plate_sweep(run) if "frequency" in run else plate_decay(run) for run in runs]
    how = found[0].how + (f", {len(found)} recordings" if len(found) > 1 else "")
    values = [
        measured(
            "plate.frequency_hz", [f.resonance for f in found], [f.method_hz for f in found], how, take.files, date
        ),
        measured("plate.q", [f.q for f in found], [f.method_q for f in found], how, take.files, date),
        measured(CORNER, [f.corner for f in found], [f.method_corner_hz for f in found], how, take.files, date),
    ]
    rows: list[tuple[str, ...]] = [("recording", "resonance", "Q", "corner of the envelope", "left")]
    rows += [
        (name, f"{f.resonance}", f"{f.q}", f"{f.corner}", f"{f.misfit:.1%}")
        for name, f in zip(take.files, found, strict=False)
    ]
    drawn = "sweep" if "frequency" in runs[0] else "decay"
    told = [line for run in runs for line in run.attrs.get("told", "").splitlines()]
    told += [line for f in found for line in f.told]
    return values, told, rows, {drawn: _drawn(found[0], runs[0])}


def _drawn(found: PlateResonance, run: xr.Dataset) -> dict[str, Any]:
    step = max(found.x.size // (4 * POINTS), 1)
    curves = {name: np.asarray(getattr(found, name))[::step].tolist() for name in ("x", "y", "fitted")}
    return curves | {"unit": run["vibration"].attrs["units"]}


def _envelope(take: Any, runs: Sequence[xr.Dataset], date: str) -> Found:
    found = [plate_envelope(run) for run in runs]
    how = f"{sum(f.jumps for f in found)} falls or rises of the envelope"
    value = measured(CORNER, [f.corner for f in found], [f.method_hz for f in found], how, take.files, date)
    rows: list[tuple[str, ...]] = [
        ("recording", "corner", "left"),
        *((n, f"{f.corner}", f"{f.misfit:.1%}") for n, f in zip(take.files, found, strict=False)),
    ]
    first = found[0]
    step = max(first.time_s.size // POINTS, 1)
    curves = {
        "x": first.time_s[::step].tolist(),
        "y": first.y[::step].tolist(),
        "fitted": first.fitted[::step].tolist(),
    }
    told = ["Q follows from the corner and the resonance, f/(2 Q)"]
    return [value], told, rows, {"envelope": curves | {"unit": runs[0]["envelope"].attrs["units"]}}


def scale(take: Any, runs: Sequence[xr.Dataset], sensor: Any, date: str) -> Found:
    """Return the amplitude in um per drive, and the largest one, from drives under a vibrometer."""
    pairs = [_pairs(run, take.frequency_hz) for run in runs]
    lines = [straight_scale(drive, amplitude, f"um/{unit or 'duty'}") for drive, amplitude, unit in pairs]
    how = f"line through {sum(line.x.size for line in lines)} drives"
    slopes, methods = [line.slope for line in lines], [line.method for line in lines]
    values = [measured("amplitude_scale", slopes, methods, how, take.files, date)]
    told = [f"R2 = {line.r2:.6f}; the upper half is {line.bend:+.1%} as steep as the lower" for line in lines]
    if take.full_drive is not None:
        ends = [_at(line, take.full_drive) for line in lines]
        off = [line.method * take.full_drive for line in lines]
        values.append(measured("plate.max_amplitude_um", ends, off, f"{how}, at {take.full_drive:g}", take.files, date))
        beyond = max(float(line.x.max()) for line in lines)
        if take.full_drive > 1.05 * beyond:
            told.append(
                f"the largest drive measured is {beyond:g}: the amplitude at {take.full_drive:g} is a guess beyond it"
            )
    unit = pairs[0][2]
    rows: list[tuple[str, ...]] = [("drive", "amplitude (um)", "residual (um)")]
    for line in lines:
        left = line.y - line.offset.value - line.slope.value * line.x
        rows += [(f"{x:.4g}", f"{y:.4g}", f"{r:+.2g}") for x, y, r in zip(line.x, line.y, left, strict=True)]
    curves = _line_drawn(lines[0], f"drive ({unit or 'duty'})", "amplitude (µm)")
    return values, told, rows[:200], {"pairs": curves}


def _pairs(run: xr.Dataset, frequency_hz: float | None) -> tuple[NDArray[np.float64], NDArray[np.float64], str]:
    dim = "row" if "row" in run.dims else "time"
    drive = channel(run, "drive", ("V", "", "counts"), dim=dim)
    if run["vibration"].attrs.get("units") == "m/s" if "vibration" in run else False:
        if frequency_hz is None:
            raise FrictionloopError("frequency_hz: must be given where the vibrometer's channel is a velocity in m/s")
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


def _at(line: Any, drive: float) -> Estimate:
    centre = float(line.x.mean())
    spread = float(np.sum((line.x - centre) ** 2))
    error = math.hypot(line.slope.standard_error * (drive - centre), line.residual / math.sqrt(line.x.size))
    return Estimate(
        line.offset.value + line.slope.value * drive, error if spread else math.inf, "um", line.slope.freedom
    )


def _line_drawn(line: Any, x: str, y: str) -> dict[str, Any]:
    step = max(line.x.size // POINTS, 1)
    fitted = line.offset.value + line.slope.value * line.x
    return {
        "x": line.x[::step].tolist(),
        "y": line.y[::step].tolist(),
        "fitted": fitted[::step].tolist(),
        "labels": [x, y],
    }


def carrier(take: Any, runs: Sequence[xr.Dataset], sensor: Any, date: str) -> Found:
    """Return how fast the resonance drifts."""
    found = [carrier_drift(run) for run in runs]
    how = f"line through {found[0].frequency_hz.size} resonances"
    methods = [f.method_hz_per_min for f in found]
    values = [measured("carrier_drift", [f.rate for f in found], methods, how, take.files, date)]
    slopes = [f.per_kelvin for f in found if f.per_kelvin is not None]
    if slopes:
        values.append(measured("carrier_drift_per_kelvin", slopes, [0.0] * len(slopes), how, take.files, date))
    rows: list[tuple[str, ...]] = [("recording", "drift", "largest less least")]
    rows += [(name, f"{f.rate}", f"{f.span_hz:.3g} Hz") for name, f in zip(take.files, found, strict=False)]
    first = found[0]
    middle = float(first.frequency_hz.mean())
    told = [
        f"the resonance moves by {f.span_hz:.3g} Hz; at a Q of {q} a carrier that stays put loses "
        f"{1 - f.share_left(middle, q):.1%}"
        for f in found
        for q in (150, 300)
    ]
    step = max(first.time_s.size // POINTS, 1)
    curves = {
        "x": (first.time_s[::step] / 60).tolist(),
        "y": (first.frequency_hz[::step] - middle).tolist(),
        "middle": middle,
    }
    return values, told, rows, {"drift": curves}


def delay(take: Any, runs: Sequence[xr.Dataset], sensor: Any, date: str) -> Found:
    """Return the delay of the loop from known jumps."""
    if take.control_hz is None:
        raise FrictionloopError("control_hz: must be given for kind 'delay', the control rate in Hz")
    found = [loop_delay(run, take.control_hz, waits=take.waits) for run in runs]
    how = f"{sum(f.jumps for f in found)} jumps" + (
        ", half a control period of waiting taken off" if take.waits else ""
    )
    value = measured("controller.delay_s", [f.delay for f in found], [f.method_s for f in found], how, take.files, date)
    rows: list[tuple[str, ...]] = [("recording", "delay", "jump to answer", "scatter of jumps")]
    rows += [
        (n, f"{f.delay}", f"{f.whole}", f"{1e6 * f.spread_s:.0f} us") for n, f in zip(take.files, found, strict=False)
    ]
    first = found[0]
    curves = {"x": first.time_s.tolist(), "y": first.answer.tolist(), "fitted": first.fitted.tolist()}
    return [value], [line for f in found for line in f.told], rows, {"answer": curves}
