"""What a person should know of a run: forces out of reach or beyond the sensor, what is not scored, turns."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionloop.analysis.operating_point import OFTEN_N, RECORDED, left_in, too_wide
from frictionloop.findings import Finding
from frictionloop.findings.result import Table, frame
from frictionloop.loop.input_findings import with_longer_stroke
from frictionloop.loop.metrics import run_reach
from frictionloop.loop.record import system_of
from frictionloop.parameters import Skin, Strokes, SuspendedSensor, System
from frictionloop.physics.motion import scored_edge_m, stroke_plan
from frictionloop.recordings.friction_defects import SHOWN, stretches

if TYPE_CHECKING:
    import xarray as xr

CLAMPED = 0.05
"""Share of the commands that are clamped, and of the time out of reach, from which on that is told (chosen)."""
UNREACHED = 0.9
"""Share of the time out of reach that is a warning (chosen); less where a recording brings its own mean."""
STEP_MM = 10.0
"""Strokes are proposed in whole centimetres."""


@dataclass(frozen=True, kw_only=True)
class ReachSplit:
    """The error where the set-point is out of reach and where it is not; their squares add up to that of all."""

    beyond: float
    """Share of the time that is scored in which no vibration gives f_r."""
    low_n: float
    high_n: float
    """What could be had, medians over the time."""
    rms_error_beyond_n: float
    rms_error_within_n: float

    def parts(self, scored: float = 1.0) -> dict[str, tuple[float, float]]:
        """Return share of the time and error, N, of both parts; none where all is on one side."""
        if not 0.0 < self.beyond < 1.0:
            return {}
        return {
            "  out of reach": (scored * self.beyond, self.rms_error_beyond_n),
            "  in reach": (scored * (1.0 - self.beyond), self.rms_error_within_n),
        }


def error_table(parts: Mapping[str, tuple[float, float]]) -> Table:
    """Return parts of a run, each a share of the time and an error in N, in per cent and mN."""
    rows = {name: (100.0 * share, 1e3 * error) for name, (share, error) in parts.items()}
    return frame(rows, "error", ["time, %", "rms, mN"])


def reach_split(run: xr.Dataset, mask: np.ndarray) -> ReachSplit:
    """Return the error of a run by reach: rms^2 = beyond^2 + within^2, each over all that is scored."""
    there, force = run_reach(run, mask), run["f_r"].values[mask]
    square, missed = (run["f_a"].values[mask] - force) ** 2, there.beyond(force)
    beyond, within = (float(np.sqrt(np.mean(square * where))) for where in (missed, ~missed))
    return ReachSplit(
        beyond=float(missed.mean()),
        low_n=float(np.median(there.low_n)),
        high_n=float(np.median(there.high_n)),
        rms_error_beyond_n=beyond,
        rms_error_within_n=within,
    )


def of_reach(run: xr.Dataset, mask: np.ndarray, split: ReachSplit) -> Iterator[Finding]:
    """Yield that a set-point is out of reach, and what may be the cause."""
    system, r, d = system_of(run), run["f_r"].values[mask], run["d"].values[mask]
    level = float(d.mean())
    centred = run_reach(run, mask, d - level)
    span_n = float(np.median(centred.high_n - centred.low_n))
    if split.beyond <= CLAMPED:
        return
    wide = too_wide(float(np.std(d)), span_n)
    if wide:
        yield Finding("DISTURBANCE-WIDE", value=float(np.std(d)), unit="N", limit=span_n)
    without = float(np.mean(centred.beyond(r)))
    remedy: Mapping[str, Any] | str = {}
    often = split.beyond >= (CLAMPED if left_in(system, abs(level)) else UNREACHED)
    if often and abs(level) > OFTEN_N and without < UNREACHED and not wide:
        recorded = system.disturbance.kind == "recording" and left_in(system, level)
        remedy = {"disturbance.remove_mean": True} if recorded else {"disturbance.offset_n": 0.0}
    elif system.setpoint.kind in RECORDED and r.min() < 0.0:
        remedy = "another setpoint.offset_n"
    yield Finding(
        "SETPOINT-REACH",
        None if often else "note",
        value=100.0 * split.beyond,
        unit="%",
        remedy=remedy,
        more={"asked": float(np.median(r)), "low": split.low_n, "high": split.high_n},
    )


def of_sensor(run: xr.Dataset, mask: np.ndarray) -> Iterator[Finding]:
    """Yield for how much of the time the force is above what the sensor can read; ``mask`` says since when."""
    sensor = system_of(run).sensor
    if not isinstance(sensor, SuspendedSensor) or "f_a" not in run:
        return
    f_a = run["f_a"].values[mask.argmax() :]
    share = float(np.mean(f_a > sensor.range_n))
    if share:
        more = {"share": 100.0 * share}
        yield Finding("RANGE-EXCEEDED", value=float(f_a.max()), unit="N", limit=sensor.range_n, more=more)


def of_unscored(run: xr.Dataset) -> Iterator[Finding]:
    """Yield when a recorded disturbance runs on and is not scored, and a stroke without a turn."""
    system = system_of(run)
    if system.disturbance.kind not in RECORDED or "scored" not in run or run["scored"].values.all():
        return
    parts = unscored_s(run)
    stroke_mm = without_turn_mm(system, run.sizes["time"] / system.controller.rate_hz)
    remedy = {} if stroke_mm is None else {"motion.stroke_mm": stroke_mm} | with_longer_stroke(stroke_mm, system)
    spans = [f"{start:.3g} to {end:.3g}" for start, end in parts[:SHOWN]]
    yield Finding("NOT-SCORED", value=len(parts), remedy=remedy, more={"spans": spans})


def unscored_s(run: xr.Dataset) -> tuple[tuple[float, float], ...]:
    """Return from when to when in s a run is not scored."""
    if "scored" not in run:
        return ()
    time_s = run["time"].values
    return tuple((float(time_s[a]), float(time_s[b])) for a, b in stretches(~run["scored"].values.astype(bool)))


def without_turn_mm(system: System, duration_s: float) -> float | None:
    """Return a stroke that does not end within a run, where one that starts at its end and stays down is too short."""
    motion, finger = system.motion, system.finger
    if not isinstance(motion, Strokes) or not isinstance(finger, Skin) or motion.start or motion.contact_s:
        return None
    edge_mm = 1e3 * (stroke_plan(motion).half_stroke_m - scored_edge_m(motion, finger))
    needed_mm = motion.speed_mm_s * duration_s + edge_mm
    return None if motion.stroke_mm >= needed_mm else STEP_MM * math.ceil(needed_mm / STEP_MM)
