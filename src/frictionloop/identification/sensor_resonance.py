"""Hits and listed responses of a project: the resonance of the sensor, its Q, and the pole behind it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.findings import Condition, Finding
from frictionloop.findings.catalogue import Severity
from frictionloop.identification.decay_modes import Modes, modes
from frictionloop.identification.estimate import Measured, measured
from frictionloop.identification.frequency_response import (
    FrequencyResponse,
    fit_resonance,
    response,
    response_table,
)
from frictionloop.identification.hits import NoHits, hits_of, pick_hits
from frictionloop.identification.project_entry_result import (
    POINTS,
    EntryResult,
    Rows,
    Sensor,
    log_rows,
    not_told,
    thinned,
    with_method,
)
from frictionloop.identification.project_file import Take
from frictionloop.identification.recording_columns import rate_of
from frictionloop.identification.recording_file import Opened, Run, Stretches
from frictionloop.identification.response_modes import response_modes
from frictionloop.quantities import FrictionloopError, must_be

NOTABLE = 0.05
"""Share of the energy from which a second mode is worth a word (assumed)."""
SAME = 0.05
"""Two modes closer than this share are one (assumed)."""
WORST_MISFIT = 0.2
"""Most of a frequency response that one resonance may leave unexplained (assumed)."""
RESONANCE = ("sensor.resonance_hz", "sensor.q")
Near = tuple[float, float] | None
"""Frequency in Hz and Q of the mode in question, None where a response does not tell it."""


def hits_entry(take: Take, runs: Sequence[Run], sensor: Sensor) -> EntryResult:
    """Return resonance and Q of the chosen mode, and the cutoff behind it where a hammer tells it."""
    names = take.files if len(runs) == len(take.files) else [str(k + 1) for k in range(len(runs))]
    struck, alone, found = _struck(runs, names)
    groups: list[Run | list[Run]] = _of_files(struck) if alone else [*struck.values()]
    free = [modes(group, take.mode, take.band_hz, take.segment_s, take.exclude) for group in groups]
    picked = same_mode(free)
    found += [each for one in free for each in one.findings]
    found += _others(*picked[0])
    if len(picked) < len(free):
        more = {"reason": f"{len(free)} have not all the {take.mode} mode"}
        found.append(Finding("LEFT-OUT", value=len(free) - len(picked), where=Condition(recording="some"), more=more))
    if len(free) == 1:
        found.append(not_told("the spread over mountings", "recorded once"))
    numbers: dict[str, Any] = {
        "hits": sum(each.hits for each in free),
        "bow_taken_off": max(each.bow for each in free),
        "modes_hz": [mode.frequency.value for mode in free[0].modes],
        "modes_q": [mode.q.value for mode in free[0].modes],
        "modes_share_of_energy": [mode.share for mode in free[0].modes],
    }
    curves = free[0].drawn() | {"decay": _drawn_decay(next(iter(struck.values())), take)}
    how = f"free decay after {sum(f.hits for f in free)} hits, {take.mode} mode"
    by_force, near = EntryResult([], [], {}, [], {}), None
    if all("hammer" in run.data_vars for run in struck.values()):
        by_force, near = hammered(take, [*struck.values()], picked[0][0].modes[picked[0][1]].frequency.value)
    values = [*_asked(picked, near, how), *by_force.measured, *extra_modes(take, free, how.partition(",")[0])]
    rows, numbers = _rows(groups, [*struck], take), {**numbers, **by_force.numbers}
    return EntryResult(values, [*found, *by_force.findings], numbers, rows, {**curves, **by_force.curves})


def _asked(
    picked: Sequence[tuple[Modes, int]], near: Near, how: str, paths: Sequence[str] = RESONANCE
) -> list[Measured]:
    """Return frequency and Q of one mode of each recording, with what another method has in their stead."""
    values = []
    for at, path in enumerate(paths):
        found = [(each.modes[k].frequency, each.modes[k].q)[at] for each, k in picked]
        shifts = [(each.method_hz, each.method_q)[at][k] for each, k in picked]
        if near is not None:
            shifts = [with_method(s, one.value - near[at]) for s, one in zip(shifts, found, strict=True)]
        values.append(measured(path, found, shifts, how))
    return values


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
    asked = sorted(each.chosen_modes[0].frequency.value for each in found)
    return _nearest(found, asked[(len(asked) - 1) // 2])


def _nearest(found: Sequence[Modes], hertz: float) -> list[tuple[Modes, int]]:
    """Return of each recording which mode is nearest to a frequency, where there is one within 5 %."""
    picked = []
    for each in found:
        k = min(range(len(each.modes)), key=lambda k: abs(each.modes[k].frequency.value - hertz))
        if abs(each.modes[k].frequency.value / hertz - 1) < SAME:
            picked.append((each, k))
    return picked


def _struck(runs: Sequence[Run], names: Sequence[str]) -> tuple[dict[str, Run], bool, list[Finding]]:
    """Return the recordings with hits, whether they are one measurement, and which are left out.

    Where most have one hit alone, as a triggered recorder saves them, all are one; where few have, these are left out.
    """
    struck: dict[str, Run] = {}
    poor: list[str] = []
    told: list[Finding] = []
    for name, run in zip(names, runs, strict=True):
        try:
            poor += [name] if isinstance(run, xr.Dataset) and pick_hits(run).good < 2 else []
        except NoHits as none:
            if len(runs) == 1:
                raise
            told.append(_left_out(name, str(none)))
        else:
            struck[name] = run
    if not struck:
        raise NoHits(str(must_be(f"recordings with hits, of {len(runs)}", 0, "1 or more")))
    if 2 * len(poor) > len(struck) or len(runs) == 1:
        return struck, bool(poor) and len(runs) > 1, told
    told += [_left_out(name, "fewer than 2 good hits", "warning") for name in poor]
    return {name: run for name, run in struck.items() if name not in poor}, False, told


def _of_files(struck: Mapping[str, Run]) -> list[Run | list[Run]]:
    """Return recordings of one hit each by the files that they are lines of, all as one where a file has one line."""
    files: dict[str, list[Run]] = {}
    for run in struck.values():
        files.setdefault(run.attrs.get("file", ""), []).append(run)
    return [*files.values()] if min(map(len, files.values())) > 1 else [[*struck.values()]]


def _left_out(name: str, reason: str, severity: Severity | None = None) -> Finding:
    return Finding("LEFT-OUT", severity, where=Condition(recording=name), more={"reason": reason})


def _drawn_decay(recording: Run, take: Take) -> dict[str, list[float]]:
    run, found = next(hits_of(recording, take.segment_s, take.exclude))
    start = found.starts[0] if found.starts else 0
    reading, time = run["f_m"].values, run["time"].values
    piece = reading[start : start + found.length]
    return thinned(4 * POINTS, time_s=time[: piece.size] - time[0], reading=piece - np.median(piece))


def hammered(take: Take, runs: Sequence[Run], near_hz: float) -> tuple[EntryResult, Near]:
    """Return what the force of a hammer adds: the mode near a frequency by its response, the pole behind it.

    That is one resonance with a pole behind it; where it leaves too much, the modes of the decays stand alone.
    """
    # The longest piece that every recording allows.
    segment_s = take.segment_s or min(found.length / rate_of(run) for run, found in hits_of(runs))
    found = response(runs, segment_s, exclude=take.exclude)
    band_hz = (0.2 * near_hz, min(2.5 * near_hz, 0.4 * found.rate_hz))
    try:
        fit = fit_resonance(found, band_hz)
        reason = f"one resonance leaves {fit.misfit:.0%}" if fit.misfit > WORST_MISFIT else ""
    except FrictionloopError as refused:
        reason = str(refused)
    doubts = [*found.findings]
    if reason:
        doubts.append(not_told("the pole behind the springs", reason))
        return EntryResult([], doubts, {}, [], {"response": _drawn(found, band_hz)}), None
    numbers = {"response_resonance": fit.resonance, "response_q": fit.q, "response_gain": fit.gain}
    one, curves = (fit.resonance.value, fit.q.value), {"response": _drawn(found, fit.band_hz)}
    lag = fit.lag
    if not lag.value > 3 * lag.standard_error:
        doubts.append(not_told("the pole behind the springs", f"lag {lag}"))
        return EntryResult([], doubts, numbers, [], curves), one
    how = f"H1 of {found.hits} hits, {fit.band_hz[0]:.0f} to {fit.band_hz[1]:.0f} Hz"
    lags = [lag]
    with suppress(FrictionloopError):  # where each has one hit, the scatter over files is that over hits
        lags = [fit_resonance(response([run], segment_s), fit.band_hz).lag for run in runs if len(runs) > 1] or lags
    of_lag = measured("sensor.cutoff_hz", lags, None, how)
    share = fit.cutoff_hz / lag.value
    between = None if of_lag.between is None else share * of_lag.between
    cutoff = replace(of_lag, value=fit.cutoff_hz, unit="Hz", within=share * of_lag.within, between=between)
    return EntryResult([cutoff], doubts, numbers, [], curves), one


def _drawn(found: FrequencyResponse, band_hz: tuple[float, float]) -> dict[str, Any]:
    hertz = found.frequency_hz
    inside = np.flatnonzero((hertz > 0.5 * band_hz[0]) & (hertz < 1.5 * band_hz[1]))
    return found.drawn(inside[log_rows(hertz[inside])])


def response_entry(take: Take, files: Sequence[Opened], sensor: Sensor) -> EntryResult:
    """Return resonance and Q of the chosen mode of each file, and how the response was fitted."""
    tables = [response_table(file) for file in files]
    phased = [bool(np.any(each.response.imag)) for each in tables]  # else the magnitude is all there is
    found = [
        response_modes(table, take.mode, take.band_hz, magnitude=not phase)
        for table, phase in zip(tables, phased, strict=True)
    ]
    picked = same_mode(found)
    whole = f"listed response of {sum(t.frequency_hz.size for t in tables)} frequencies"
    how = f"{take.mode} mode of a {whole}"
    rows: Rows = [("file", "mode (Hz)", "Q", "share of the peaks", "misfit")]
    for name, each in zip(take.files, found, strict=True):
        rows += [
            (name, str(mode.frequency), str(mode.q), f"{mode.share:.0%}", f"{each.misfit:.1%}") for mode in each.modes
        ]
    values = [*_asked(picked, None, how), *extra_modes(take, found, whole)]
    modes = found[0].modes
    doubts = [] if all(phased) else [not_told("the phase", "magnitudes alone")]
    doubts += _others(*picked[0])
    numbers = {"modes_hz": [m.frequency.value for m in modes], "modes_q": [m.q.value for m in modes]}
    fitted = {"fitted_hz": [hertz for hertz, _ in found[0].fitted], "fitted": [size for _, size in found[0].fitted]}
    return EntryResult(values, doubts, numbers, rows, {"response": tables[0].drawn() | fitted})


def extra_modes(take: Take, found: Sequence[Modes], how: str) -> list[Measured]:
    """Return frequency and Q of the modes that an entry wants listed, as many as there are, by names of their own."""
    values: list[Measured] = []
    for k, mode in enumerate(found[0].modes[: take.count or 0], 1):
        values += _asked(_nearest(found, mode.frequency.value), None, how, (f"mode {k}", f"mode {k} Q"))
    return values


def _others(found: Modes, chosen: int) -> list[Finding]:
    """Return the strongest mode that a bench with one resonance leaves out."""
    rest = [mode for k, mode in enumerate(found.modes) if k != chosen and mode.share >= NOTABLE]
    if not rest:
        return []
    mode = max(rest, key=lambda each: each.share)
    more = {"q": mode.q.value, "share": 100 * mode.share}
    return [Finding("MODE-LEFT-OUT", value=mode.frequency.value, unit="Hz", more=more)]
