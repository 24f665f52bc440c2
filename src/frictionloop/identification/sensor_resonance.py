"""Hits and listed responses of a project: the resonance of the sensor, its Q, and the pole behind it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.findings import Condition, Finding
from frictionloop.identification.decay_modes import Modes, modes
from frictionloop.identification.entry_result import (
    POINTS,
    EntryResult,
    Rows,
    Sensor,
    not_told,
    thin,
    thinned,
    with_method,
)
from frictionloop.identification.estimate import Estimate, Measured, measured
from frictionloop.identification.frequency_response import FrequencyResponse, has_phase, response, response_table
from frictionloop.identification.hits import NoHits, hits_of, pick_hits
from frictionloop.identification.project_file import Take
from frictionloop.identification.recording_columns import rate_of
from frictionloop.identification.recording_file import Opened, Run, Stretches
from frictionloop.identification.resonance import fit_resonance
from frictionloop.identification.response_modes import response_modes
from frictionloop.quantities import FrictionloopError, must_be

SAME = 0.05
"""Two modes closer than this share are one (assumed)."""
WORST_MISFIT = 0.2
"""Most of a frequency response that one resonance may leave unexplained (assumed)."""
Near = tuple[float, float] | None
"""Frequency in Hz and Q of the mode in question, None where a response does not tell it."""


def hits_entry(take: Take, runs: Sequence[Run], sensor: Sensor, date: str) -> EntryResult:
    """Return resonance and Q of the chosen mode, and the cutoff behind it where a hammer tells it."""
    names = take.files if len(runs) == len(take.files) else [str(k + 1) for k in range(len(runs))]
    struck, alone, found = _struck(runs, names)
    groups: list[Run | list[Run]] = [[*struck.values()]] if alone else [*struck.values()]
    free = [modes(group, take.mode, take.band_hz, take.segment_s, take.exclude) for group in groups]
    picked = same_mode(free)
    chosen = [each.modes[k] for each, k in picked]
    found += [each for one in free for each in one.findings]
    found += _turned(struck, take)
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
    shift_hz = [each.method_hz[k] for each, k in picked]
    shift_q = [each.method_q[k] for each, k in picked]
    curves = free[0].drawn() | {"decay": _drawn_decay(next(iter(struck.values())), take)}
    how = f"free decay after {sum(f.hits for f in free)} hits, {take.mode} mode"
    extra: list[Measured] = []
    if all("hammer" in run.data_vars for run in struck.values()):
        by_force, near = hammered(take, [*struck.values()], chosen[0].frequency.value, date)
        found += by_force.findings
        numbers |= by_force.numbers
        extra = list(by_force.measured)
        curves |= by_force.curves
        if near is not None:
            hertz, q = near
            shift_hz = [with_method(s, c.frequency.value - hertz) for s, c in zip(shift_hz, chosen, strict=True)]
            shift_q = [with_method(s, c.q.value - q) for s, c in zip(shift_q, chosen, strict=True)]
    values = [
        measured("sensor.resonance_hz", [m.frequency for m in chosen], shift_hz, how, take.files, date),
        measured("sensor.q", [m.q for m in chosen], shift_q, how, take.files, date),
        *extra,
        *extra_modes(take, free[0], how.partition(",")[0], date),
    ]
    return EntryResult(values, found, numbers, _rows(groups, [*struck], take), curves)


def _turned(struck: dict[str, Run], take: Take) -> list[Finding]:
    """Return that the pulses of a hammer are negative; its response is turned round for that."""
    found = (next(hits_of(run, take.segment_s))[1] for run in struck.values())
    inverted = [
        (name, min(hit.peak for hit in each.table))
        for name, each in zip(struck, found, strict=True)
        if each.inverted and each.channel == "hammer"
    ]
    return [_sign(Condition(recording=name, channel="hammer"), peak, 0.0, "N") for name, peak in inverted]


def _sign(where: Condition, low: float, high: float, unit: str) -> Finding:
    return Finding("SIGN-DOUBT", unit=unit, where=where, remedy="sign = -1", more={"low": low, "high": high})


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
    hertz = asked[(len(asked) - 1) // 2]
    picked = []
    for each in found:
        near = [k for k, mode in enumerate(each.modes) if abs(mode.frequency.value / hertz - 1) < SAME]
        if near:
            picked.append((each, min(near, key=lambda k: abs(each.modes[k].frequency.value - hertz))))
    return picked


def _struck(runs: Sequence[Run], names: Sequence[str]) -> tuple[dict[str, Run], bool, list[Finding]]:
    """Return the recordings with hits, whether some have one alone (then all are one), and which are left out."""
    struck: dict[str, Run] = {}
    alone = False
    told: list[Finding] = []
    for name, run in zip(names, runs, strict=True):
        try:
            alone |= isinstance(run, xr.Dataset) and pick_hits(run).good < 2
        except NoHits as none:
            if len(runs) == 1:
                raise
            told.append(Finding("LEFT-OUT", where=Condition(recording=name), more={"reason": str(none)}))
        else:
            struck[name] = run
    if not struck:
        raise NoHits(str(must_be(f"recordings with hits, of {len(runs)}", 0, "1 or more")))
    return struck, alone and len(runs) > 1, told


def _drawn_decay(recording: Run, take: Take) -> dict[str, list[float]]:
    run, found = next(hits_of(recording, take.segment_s, take.exclude))
    start = found.starts[0] if found.starts else 0
    reading, time = run["f_m"].values, run["time"].values
    piece = reading[start : start + found.length]
    return thinned(4 * POINTS, time_s=time[: piece.size] - time[0], reading=piece - np.median(piece))


def hammered(take: Take, runs: Sequence[Run], near_hz: float, date: str) -> tuple[EntryResult, Near]:
    """Return what the force of a hammer adds: the mode near a frequency by its response, the pole behind it.

    That is one resonance with a pole behind it; where it leaves too much, the modes of the decays stand alone.
    """
    found = response(runs, take.segment_s or _segment(runs), exclude=take.exclude)
    band_hz = (0.2 * near_hz, min(2.5 * near_hz, 0.4 * found.rate_hz))
    try:
        fit = fit_resonance(found, band_hz)
        reason = f"one resonance leaves {fit.misfit:.0%}" if fit.misfit > WORST_MISFIT else ""
    except FrictionloopError as refused:
        reason = str(refused)
    if reason:
        doubts = [not_told("the pole behind the springs", reason)]
        return EntryResult([], doubts, {}, [], {"response": _drawn(found, band_hz)}), None
    numbers = {"response_resonance": fit.resonance, "response_q": fit.q, "response_gain": fit.gain}
    one, curves = (fit.resonance.value, fit.q.value), {"response": _drawn(found, fit.band_hz)}
    doubts = []
    if fit.gain.value < 0:
        doubts = [_sign(Condition(channel="f_m or hammer"), fit.gain.value, 0.0, fit.gain.unit)]
    lag = fit.lag
    if not lag.value > 3 * lag.standard_error:
        doubts.append(not_told("the pole behind the springs", f"lag {lag}"))
        return EntryResult([], doubts, numbers, [], curves), one
    cutoff = Estimate(fit.cutoff_hz, fit.cutoff_hz * lag.standard_error / lag.value, "Hz", lag.freedom)
    how = f"H1 of {found.hits} hits, {fit.band_hz[0]:.0f} to {fit.band_hz[1]:.0f} Hz"
    extra = [measured("sensor.cutoff_hz", [cutoff], None, how, take.files, date)]
    return EntryResult(extra, doubts, numbers, [], curves), one


def _segment(runs: Sequence[Run]) -> float:
    """Return the longest piece that every recording allows, in s."""
    return min(found.length / rate_of(run) for run, found in hits_of(runs))


def _drawn(found: FrequencyResponse, band_hz: tuple[float, float]) -> dict[str, Any]:
    inside = (found.frequency_hz > 0.5 * band_hz[0]) & (found.frequency_hz < 1.5 * band_hz[1])
    hertz, size = thin(found.frequency_hz[inside], np.abs(found.response[inside]))
    _, coherence = thin(found.frequency_hz[inside], found.coherence[inside])
    return {"frequency_hz": hertz, "magnitude": size, "coherence": coherence}


def response_entry(take: Take, files: Sequence[Opened], sensor: Sensor, date: str) -> EntryResult:
    """Return resonance and Q of the chosen mode of each file, and how the response was fitted."""
    tables = [response_table(file) for file in files]
    phased = [has_phase(each) for each in tables]
    found = [
        response_modes(table, take.mode, take.band_hz, magnitude=not phase)
        for table, phase in zip(tables, phased, strict=True)
    ]
    chosen = [each.chosen[0] for each in found]
    whole = f"listed response of {sum(t.frequency_hz.size for t in tables)} frequencies"
    how = f"{take.mode} mode of a {whole}"
    rows: Rows = [("file", "mode (Hz)", "Q", "share of the peaks", "misfit")]
    for name, each in zip(take.files, found, strict=True):
        rows += [
            (name, str(mode.frequency), str(mode.q), f"{mode.share:.0%}", f"{each.misfit:.1%}") for mode in each.modes
        ]
    first = [each.chosen_modes[0] for each in found]
    shift_hz = [each.method_hz[k] for each, k in zip(found, chosen, strict=True)]
    shift_q = [each.method_q[k] for each, k in zip(found, chosen, strict=True)]
    values = [
        measured("sensor.resonance_hz", [mode.frequency for mode in first], shift_hz, how, take.files, date),
        measured("sensor.q", [mode.q for mode in first], shift_q, how, take.files, date),
        *extra_modes(take, found[0], whole, date),
    ]
    modes = found[0].modes
    doubts = [] if all(phased) else [not_told("the phase", "magnitudes alone")]
    numbers = {"modes_hz": [m.frequency.value for m in modes], "modes_q": [m.q.value for m in modes]}
    fitted = {"fitted_hz": [hertz for hertz, _ in found[0].fitted], "fitted": [size for _, size in found[0].fitted]}
    return EntryResult(values, doubts, numbers, rows, {"response": tables[0].drawn() | fitted})


def extra_modes(take: Take, found: Modes, how: str, date: str) -> list[Measured]:
    """Return frequency and Q of as many modes as an entry wants listed, under names of their own."""
    if take.count is None:
        return []
    listed = found.modes[: take.count]
    if len(listed) < take.count:
        raise must_be("count", take.count, f"at most {len(listed)}")
    values: list[Measured] = []
    for k, mode in enumerate(listed):
        values.append(measured(f"mode {k + 1}", [mode.frequency], [found.method_hz[k]], how, take.files, date))
        values.append(measured(f"mode {k + 1} Q", [mode.q], [found.method_q[k]], how, take.files, date))
    return values
