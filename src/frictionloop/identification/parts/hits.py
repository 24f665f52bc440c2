"""Hits of a project: the resonance of the sensor, its Q, and the pole behind it where a hammer tells it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.identification.hit_runs import hits_of
from frictionloop.identification.hits import NoHits, pick_hits
from frictionloop.identification.long import Run, Stretches
from frictionloop.identification.measured import Measured, measured
from frictionloop.identification.mode import Modes
from frictionloop.identification.modes import modes
from frictionloop.identification.parts.hammer import hammered
from frictionloop.identification.parts.part import POINTS, Found, Rows, Sensor, extra_modes, with_method
from frictionloop.identification.project import Take

SAME = 0.05
"""Two modes closer than this share are one (assumed)."""


def hits_part(take: Take, runs: Sequence[Run], sensor: Sensor, date: str) -> Found:
    """Return resonance and Q of the chosen mode, and the cutoff behind it where a hammer tells it."""
    names = take.files if len(runs) == len(take.files) else [str(k + 1) for k in range(len(runs))]
    struck, alone, told = _struck(runs, names)
    groups: list[Run | list[Run]] = [[*struck.values()]] if alone else [*struck.values()]
    free = [modes(group, take.mode, take.band_hz, take.segment_s, take.exclude) for group in groups]
    picked = same_mode(free)
    chosen = [found.modes[k] for found, k in picked]
    told += [each.told for each in free]
    told += _turned(struck, take)
    listed = [f"{m.frequency.value:.5g} Hz (Q {m.q.value:.3g}, {m.share:.0%} of the energy)" for m in free[0].modes]
    told.append(f"modes: {', '.join(listed)}; the {take.mode} one is taken for the sensor's resonance")
    if len(picked) < len(free):
        told.append(f"{len(free) - len(picked)} of {len(free)} recordings do not show that mode, and are left out")
    if len(free) == 1:
        told.append("one measurement: what changes when the sensor is mounted anew or hit elsewhere is not in it")
    shift_hz = [found.method_hz[k] for found, k in picked]
    shift_q = [found.method_q[k] for found, k in picked]
    curves: dict[str, Any] = {"poles": [(p.order, p.frequency_hz, p.stable) for p in free[0].diagram]}
    curves["modes_hz"] = [m.frequency.value for m in free[0].modes]
    curves["decay"] = _drawn_decay(next(iter(struck.values())), take)
    how = f"free decay after {sum(f.hits for f in free)} hits, {take.mode} mode"
    extra: list[Measured] = []
    if all("hammer" in run.data_vars for run in struck.values()):
        by_force = hammered(take, [*struck.values()], free[0], chosen[0].frequency.value, date)
        told.append(by_force.told)
        extra = by_force.extra
        if by_force.mode is not None:
            hertz, q = by_force.mode
            shift_hz = [with_method(s, c.frequency.value - hertz) for s, c in zip(shift_hz, chosen, strict=True)]
            shift_q = [with_method(s, c.q.value - q) for s, c in zip(shift_q, chosen, strict=True)]
            curves["response"] = by_force.curve
    values = [
        measured("sensor.resonance_hz", [m.frequency for m in chosen], shift_hz, how, take.files, date),
        measured("sensor.q", [m.q for m in chosen], shift_q, how, take.files, date),
        *extra,
        *extra_modes(take, free[0], how.partition(",")[0], date),
    ]
    return values, told, _rows(groups, [*struck], take), curves


def _turned(struck: dict[str, Run], take: Take) -> list[str]:
    """Return in words that the pulses of a hammer are negative; its response is turned round for that."""
    found = (next(hits_of(run, take.segment_s))[1] for run in struck.values())
    named = [name for name, each in zip(struck, found, strict=True) if each.inverted and each.channel == "hammer"]
    said = "the pulses of the hammer are negative and were turned round: its map needs sign = -1"
    return [f"{', '.join(named)}: {said}"] if named else []


def _rows(groups: Sequence[Run | Sequence[Run]], names: Sequence[str], take: Take) -> Rows:
    """Return the table of every hit."""
    rows: Rows = [("recording", "hit", "time (s)", "peak", "verdict")]
    left = list(names)
    for group in groups:
        name = ""
        for _, found in hits_of(group, take.segment_s, take.exclude):
            # A long recording comes in parts, which have one name.
            name = name if isinstance(group, Stretches) and name else left.pop(0)
            rows += [
                (name, str(h.number), f"{h.time_s:.3f}", f"{h.peak:.3g}", h.reason or h.verdict) for h in found.table
            ]
    return rows


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


def _struck(runs: Sequence[Run], names: Sequence[str]) -> tuple[dict[str, Run], bool, list[str]]:
    """Return the recordings with hits, whether some have one alone (then all are one), and which are left out."""
    struck: dict[str, Run] = {}
    alone, told = False, []
    for name, run in zip(names, runs, strict=True):
        try:
            alone |= isinstance(run, xr.Dataset) and pick_hits(run).good < 2
        except NoHits as none:
            if len(runs) == 1:
                raise
            told.append(f"{name} is left out: {none}")
        else:
            struck[name] = run
    if not struck:
        raise NoHits(f"none of {len(runs)} recordings has a hit; accepted: hits that stand out of the noise")
    return struck, alone and len(runs) > 1, told


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
