"""A controller on a device, recorded: how far the measured force is off where it counts, and what was lost."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.device.board_discovery import opened
from frictionloop.device.device import Device
from frictionloop.device.device_run import carried
from frictionloop.device.recording import away_from_turns
from frictionloop.device.waveform import upload_of
from frictionloop.findings import Finding, Result
from frictionloop.findings.result import Row
from frictionloop.findings.shown import shown
from frictionloop.firmware.board_compatibility import board_findings
from frictionloop.firmware.effect_tables import EffectTables, write_tables
from frictionloop.loop.metrics import r2_identity, saturation_index
from frictionloop.loop.progress import step
from frictionloop.loop.run_ringing import of_ringing, rings_alone, run_ringing
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError, must_be

TURN_MM = 2.0
"""So near to a turn nothing counts: the friction changes its sign there. As in `simulate` at a
stiffness of 1000 N/m; that of a real finger is not known."""
LONGEST_S = 86400.0
SCORED_S = 600.0
"""Of a longer run the last part is scored and drawn: what it takes in memory does not grow with the run."""
CLAMPED, MISSING = 0.05, 0.1
"""Shares of commands clamped, and of R2 missing, from which a loop is looked at for ringing (chosen)."""
AT_CEILING, FAR_N = 0.2, 0.02
"""Share of the time at the ceiling, and the mean error there, from which the ceiling is named (chosen)."""
LOST = ("lost_samples", "gaps", "reconnects", "broken_frames", "missed_frames")


class DeviceRun(Result, schema="device.run/1", without="recording", eq=False):
    """A run on a device."""

    address: str
    source: str
    """simulated, emulated or device."""
    state: str
    """open or closed."""
    recording: xr.Dataset
    """The last `SCORED_S` at most, ``scored`` where it counts; `save` writes it, `plot` draws it."""
    samples: int
    scored_samples: int
    counted: float
    """Share of those: a finger slides, `TURN_MM` or more from where it turns."""
    measured_rms_error_n: float
    """Of f_m, by the device's own sensor with its springs, lag and noise; NaN where nothing counts."""
    rms_error_n: float | None
    """Of f_a, on the finger, which a simulated bench alone tells."""
    saturation_index: float
    """Share of the commands that were clamped."""
    at_ceiling: float
    """Share of the time."""
    setpoint_error_n: float
    """By how much the points that the device plays miss the set-point, rms."""
    lost_samples: int
    gaps: int
    reconnects: int
    broken_frames: int
    missed_frames: int

    def rows(self) -> list[Row]:
        """Return the error and what counts of it."""
        error = f"{shown(1e3 * self.measured_rms_error_n)} mN rms by its own sensor"
        if self.rms_error_n is not None:
            error += f", {shown(1e3 * self.rms_error_n)} on the finger"
        of = f"the last {self.scored_samples:,} of " if self.scored_samples < self.samples else ""
        return [
            ("error", error if self.counted else "-"),
            ("clamped", f"{100.0 * self.saturation_index:.3g} % of the commands" if self.counted else "-"),
            ("counted", f"{100.0 * self.counted:.3g} % of {of}{self.samples:,} samples"),
        ]


class DevicePlay(DeviceRun, schema="device.play/1", without="effect_tables", eq=False):
    """An effect on a device."""

    effect_tables: EffectTables
    steps: int
    words: int
    table_error_n: float
    """Largest difference of its tables from the simulator's."""

    def rows(self) -> list[Row]:
        """Return the run, and what the device was given."""
        return [*super().rows(), ("effect", f"steps {self.steps}, words {self.words}")]

    def write_tables(self, path: str | os.PathLike[str]) -> None:
        """Write what the device was given as JSON: steps, values, and the words themselves."""
        write_tables(self.effect_tables, Path(path))


def run(
    where: str | Device,
    system: System,
    duration_s: float = 10.0,
    *,
    decimation: int = 1,
    open_loop: bool = False,
    out: str | os.PathLike[str] | None = None,
) -> DeviceRun:
    """Load a System's controller into a device, close the loop, play its set-point and record.

    Parameters
    ----------
    where
        Address as of `connect`, or a Device.
    system
        Its bench, controller and set-point; behind a simulated board also what is simulated.
    duration_s
        In s; of more than `SCORED_S` the last part is scored.
    decimation
        Ticks per sample, 1 to 65535.
    open_loop
        Lookup table alone, nothing fed back.
    out
        File of the recording (HDF5); needed for more than `SCORED_S`.

    Raises
    ------
    FrictionloopError
        For a system that the firmware cannot run; DeviceError when the device faults, is gone, or is changed: its code
        says which, and the recording until then is kept.
    """
    check_duration(duration_s, out)
    with opened(where, system) as device:
        _load(device, system)
        taken = device.run(
            system.setpoint,
            duration_s,
            path=out,
            state="open" if open_loop else "closed",
            decimation=decimation,
            progress=_steps(duration_s, decimation / device.info.tick_hz),
        )
        return DeviceRun(**scored(taken, system, device.address, open_loop, _thinned(decimation, device.info.tick_hz)))


def play(
    where: str | Device,
    system: System,
    duration_s: float = 10.0,
    *,
    open_loop: bool = False,
    out: str | os.PathLike[str] | None = None,
) -> DevicePlay:
    """Load a controller and the effect that is its set-point into a device, close the loop and record.

    Parameters and errors are those of `run`; also refused is a set-point that is no effect, or has more steps, triggers
    or values than a device has room for.
    """
    check_duration(duration_s, out)
    with opened(where, system) as device:
        made = upload_of(system.setpoint, system, device.info.waveform, device.info.tick_hz)
        if made is None:
            raise must_be("setpoint.kind", system.setpoint.kind, "effect")
        _load(device, system)
        state, progress = "open" if open_loop else "closed", _steps(duration_s, 1.0 / device.info.tick_hz)
        taken = device.run(made.source, duration_s, path=out, state=state, progress=progress)
        found = scored(taken, system, device.address, open_loop, _thinned(1, device.info.tick_hz))
    tables = made.tables
    return DevicePlay(
        **found | {"findings": (*found["findings"], *tables.findings)},
        effect_tables=tables,
        steps=len(tables.program.code),
        words=len(tables.words),
        table_error_n=tables.error_n,
    )


def check_duration(duration_s: float, out: str | os.PathLike[str] | None) -> None:
    """Refuse a run that no memory holds."""
    longest_s = LONGEST_S if out is not None else SCORED_S
    if not 0 < duration_s <= longest_s:
        more = "" if out is not None else "; longer with out"
        raise must_be("duration_s", float(duration_s), f"above 0, at most {longest_s:g}{more}", "s")


def _thinned(decimation: int, tick_hz: int) -> list[Finding]:
    """Return that a line carries fewer samples than were asked for."""
    ticks = carried(decimation, tick_hz)
    return [Finding("LINE-CARRIES", value=ticks, limit=decimation)] if ticks != decimation else []


def scored(
    taken: xr.Dataset, system: System, address: str, open_loop: bool, more: Sequence[Finding] = ()
) -> dict[str, Any]:
    """Return the fields of `DeviceRun`."""
    recording = last(taken, SCORED_S)
    counts = counted(recording)
    recording = recording.assign(scored=recording["scored"].copy(data=counts))
    attrs = recording.attrs
    found: dict[str, Any] = {
        "address": address,
        "source": str(attrs["source"]),
        "state": "open" if open_loop else "closed",
        "recording": recording,
        "samples": taken.sizes["time"],
        "scored_samples": recording.sizes["time"],
        "counted": float(counts.mean()),
        "measured_rms_error_n": _rms(recording, "f_m", counts),
        "rms_error_n": _rms(recording, "f_a", counts) if "f_a" in recording else None,
        "saturation_index": saturation_index(_known(recording), counts) if counts.any() else math.nan,
        "setpoint_error_n": float(attrs["setpoint_error_n"]),
        **{name: int(attrs[name]) for name in LOST},
    }
    share, held = _at_ceiling(recording, counts, system)
    lost = f"lost, in {found['gaps']} gaps"
    told = [
        *board_findings(system),
        *more,
        *([Finding("SAMPLES-LOST", value=found["lost_samples"], limit=found["samples"], more={"how": lost})]
          if found["lost_samples"] else []),
        *held,
        *(() if open_loop else diagnosed(recording, counts)),
    ]  # fmt: skip
    return found | {"at_ceiling": share, "findings": tuple(told)}


def diagnosed(recording: xr.Dataset, counts: np.ndarray) -> Iterator[Finding]:
    """Yield that the loop of a recording rings, as ``fl.diagnose`` finds it, where its signs tell of it."""
    if not counts.any():
        return
    known = _known(recording)
    clamped, followed = saturation_index(known, counts), r2_identity(known, counts)
    if clamped <= CLAMPED and 1.0 - followed <= MISSING:  # of a constant set-point R2 is NaN: it is looked at
        return
    with suppress(FrictionloopError):  # a recording beyond the sensor's range has no levels
        found = run_ringing(known, counts)
        for each in of_ringing(found, rings_alone(known, counts, found)):
            yield replace(each, remedy="frictionloop design controller")


def last(taken: xr.Dataset, longest_s: float) -> xr.Dataset:
    """Return the last part of a run, read from its file if it is not in memory."""
    times = taken["time"]
    rows = round(longest_s / float(times[1] - times[0])) if times.size > 1 else 1
    part = taken.isel(time=slice(-max(rows, 1), None)).load()
    if part.sizes["time"] < times.size:
        taken.close()
    return part


def counted(recording: xr.Dataset) -> np.ndarray:
    """Return which samples count: recorded, of a finger that slides, away from its turns."""
    away = away_from_turns(recording["position"].values, recording["speed"].values, 1e-3 * TURN_MM)
    return (recording["scored"] & recording["sliding"]).values.astype(bool) & away


def _load(device: Device, system: System) -> None:
    device.upload(system)
    device.clear()  # of a fault that an earlier run ended with; refused while its cause lasts


def _known(recording: xr.Dataset) -> xr.Dataset:
    """Return a recording with the measured force for one on the finger that nobody knows."""
    return recording if "f_a" in recording else recording.assign(f_a=recording["f_m"])


def _rms(recording: xr.Dataset, name: str, counts: np.ndarray) -> float:
    error = (recording[name] - recording["f_r"]).values[counts]
    return float(np.sqrt(np.nanmean(error**2))) if np.isfinite(error).any() else math.nan


def _at_ceiling(recording: xr.Dataset, counts: np.ndarray, system: System) -> tuple[float, list[Finding]]:
    """Return the share of the time at the largest amplitude, and that the force is too high then."""
    largest_um = system.plate.max_amplitude_um
    ceiling_um = system.board.ceiling_um or largest_um
    force = recording["f_a" if "f_a" in recording else "f_m"].values
    there = counts & (recording["a"].values >= 0.99 * ceiling_um)
    share = float(there.sum() / max(counts.sum(), 1))
    above_n = float(np.nanmean((force - recording["f_r"].values)[there])) if there.any() else 0.0
    if share < AT_CEILING or above_n < FAR_N:
        return share, []
    more = {"share": 100.0 * share, "above": 1e3 * above_n}
    return share, [Finding("AT-CEILING", value=ceiling_um, unit="um", limit=largest_um, more=more)]


def _steps(duration_s: float, sample_s: float) -> Callable[[int], None]:
    """Return what takes the number of samples recorded so far, and tells each second."""
    told = -1

    def go_to(samples: int) -> None:
        nonlocal told
        if (now := math.floor(samples * sample_s + 1e-9)) > told:
            told = now
            step(f"{told} of {duration_s:g} s")

    return go_to
