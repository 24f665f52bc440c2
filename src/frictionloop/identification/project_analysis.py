"""The entries of a project, one after the other: what each gave, which were refused, what is kept for the next time."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.findings import Condition, Finding
from frictionloop.findings.result import plain
from frictionloop.identification.channel_summary import clipped_share
from frictionloop.identification.estimate import Measured
from frictionloop.identification.linear_calibration import carrier_entry, position_entry, scale_entry
from frictionloop.identification.loop_delay import delay_entry
from frictionloop.identification.plate_decay import plate_entry
from frictionloop.identification.project_entry_result import EntryResult, Refused, Sensor, pictured
from frictionloop.identification.project_file import ChannelMap, Project, Take
from frictionloop.identification.quiet import quiet_entry
from frictionloop.identification.recording_columns import READING
from frictionloop.identification.recording_file import (
    Opened,
    Run,
    Stretches,
    calm,
    findings_of,
    means,
    opened,
    sha256,
)
from frictionloop.identification.sensor_resonance import hits_entry, response_entry
from frictionloop.identification.slides import slides_entry
from frictionloop.identification.susceptibility import amplitude_entry
from frictionloop.identification.weights_calibration import hung, standing
from frictionloop.identification.weights_straightness import load_entry, weights_entry
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.code_version import package_version
from frictionloop.recordings.file_opening import read_contents

ANALYSES: Mapping[str, Callable[..., EntryResult]] = {
    "weights": weights_entry,
    "hits": hits_entry,
    "response": response_entry,
    "quiet": quiet_entry,
    "load": load_entry,
    "position": position_entry,
    "scale": scale_entry,
    "plate": plate_entry,
    "carrier": carrier_entry,
    "delay": delay_entry,
    "slides": slides_entry,
    "amplitude": amplitude_entry,
}
"""What analyses an entry, by its kind, in the order in which one needs the other: ``(take, runs, sensor)``."""
IN_PARTS = ("weights", "hits", "quiet", "slides")
"""Kinds of which a long recording is read in parts."""
OVER_TIME = ("hits", "quiet", "slides", "delay", "amplitude")
"""Kinds that no table can give."""
MOST_CLIPPED = 0.01
"""Share of the samples of a recording that may be clipped (assumed)."""
FORM = 4
"""Of what is kept: another one is not read."""
USE_SENSOR = ("quiet", "slides", "load", "amplitude")
"""Kinds whose analysis depends on what is known of the sensor."""


def analyse(take: Take, folder: Path, sensor: Sensor) -> EntryResult:
    """Analyse the recordings of one entry."""
    by_file = [_loaded(folder / name, take, folder) for name in take.files]
    files = tuple(
        {"path": name, "sha256": runs[0].attrs["sha256"], "date": take.date or runs[0].attrs["date"]}
        for name, runs in zip(take.files, by_file, strict=True)
    )
    runs = [run for each in by_file for run in each]
    try:
        if take.masses_g is not None:
            masses = 1e-3 * np.array(take.masses_g)
            runs = [hung(standing(runs[0], masses.size, take.settle_s) if len(runs) == 1 else runs, masses)]
        for run in runs:
            _refuse_unfit(run, take.kind)
        found = ANALYSES[take.kind](take, runs, sensor)
        values = [replace(each, files=take.files, date=files[0]["date"]) for each in found.measured]
        if take.kind in USE_SENSOR:
            values = [sensor.divided(each, runs) for each in values]
    except FrictionloopError as refused:
        where = ", ".join(take.files) if len(take.files) < 4 else f"{take.files[0]} and {len(take.files) - 1} more"
        raise pictured(refused, f"{where}: {refused}", take.kind, folder / take.files[0], take.rate_hz) from None
    every = [each for run in runs for each in findings_of(run.attrs)]
    findings = (*(each for k, each in enumerate(every) if each not in every[:k]), *found.findings)
    return EntryResult(values, findings, plain(found.numbers), found.rows, found.curves, take.kind, files)


def _refuse_unfit(run: Any, kind: str) -> None:
    """Refuse a table where a recording over time is needed, and one that is clipped where no hit can be left out."""
    if not isinstance(run, xr.Dataset):
        return
    if kind in OVER_TIME and "row" in run.dims:
        raise must_be(f"{kind}: rows", run.sizes["row"], "samples over time")
    for name in (READING, "load"):
        if kind in ("quiet", "slides", "amplitude") and name in run.data_vars:
            share = clipped_share(np.asarray(run[name].values, dtype=float))
            if share > MOST_CLIPPED:
                raise must_be(f"{name}: share clipped", share, f"at most {MOST_CLIPPED:g}", "", "CLIPPED")


def _loaded(path: Path, take: Take, folder: Path) -> list[Any]:
    """Return the recordings of a file: one, or one for each line of an array whose column is ``name[:, *]``."""
    chart = take.chart(folder)
    if take.kind == "response":
        return [opened(path, chart, table=True, decimal=take.decimal)]
    columns = {} if chart is None else {name: str(each.column) for name, each in chart.channels.items()}
    if chart is None or not any("*" in column for column in columns.values()):
        return [_run(opened(path, chart, **take.reading), take)]
    masses = None
    if take.kind == "weights" and "*" not in columns.get("mass", "*"):
        one = ChannelMap(channels={"mass": chart.channels["mass"]})
        file = opened(path, one, table=True, **take.reading)
        masses = file.whole()["mass"].values
        others = {name: each for name, each in chart.channels.items() if name != "mass"}
        chart = chart.model_copy(update={"channels": others})
    there = {line.name for line in read_contents(path, take.decimal).channels}
    starred = [column for column in columns.values() if "*" in column]
    found: list[Any] = []
    while all(_numbered(column, len(found)) in there for column in starred):
        tree = chart.model_dump()
        for each in tree["channels"].values():
            each["column"] = _numbered(each["column"], len(found))
        found.append(_run(opened(path, ChannelMap.from_tree(tree), **take.reading), take))
    if not found:
        return [_run(opened(path, chart, **take.reading), take)]
    return found if masses is None else [hung(found, masses)]


def _numbered(column: str | int, k: int) -> str | int:
    """Return the column of recording k, counted from 0; cells and structures of MATLAB count from 1."""
    if isinstance(column, int):
        return column
    return column.replace("{*}", f"{{{k + 1}}}").replace("(*)", f"({k + 1})").replace("*", str(k))


def _run(file: Opened, take: Take) -> Run:
    """Return a recording whole, or of a long one that can be read in parts what its analysis needs."""
    if not file.is_long or take.kind not in IN_PARTS:
        return file.whole()
    if take.kind == "hits":
        return Stretches(file, "hammer" if "hammer" in file.picked else READING)
    return calm(file, take.interval_s) if take.kind == "quiet" else means(file)


class RefusedEntry(NamedTuple):
    """An entry whose files or analysis were refused."""

    kind: str
    said: str
    """The line, which names the file."""


@dataclass
class Work:
    """What has been done of a project."""

    parts: list[tuple[str, EntryResult]] = field(default_factory=list)
    """With what each depends on, as a hash."""
    sensor: Sensor = field(default_factory=Sensor)
    analysed: int = 0
    errors: list[tuple[str, FrictionloopError]] = field(default_factory=list)
    """Kinds of the entries that were refused, and how."""

    @property
    def refused(self) -> tuple[RefusedEntry, ...]:
        """Entries that were refused."""
        return tuple(RefusedEntry(kind, str(error)) for kind, error in self.errors)

    def findings(self) -> list[Finding]:
        """Return which entries were left out."""
        return [
            Finding("LEFT-OUT", "warning", where=Condition(recording=each.kind), more={"reason": each.said})
            for each in self.refused
        ]

    def refusal(self) -> FrictionloopError:
        """Return the refusals in one line, and which results are kept."""
        said = "; ".join(dict.fromkeys(str(error) for _, error in self.errors))
        first = next((error for _, error in self.errors if isinstance(error, Refused)), Refused("", "recording", {}))
        done = ", ".join(dict.fromkeys(part.kind for _, part in self.parts))
        return Refused(f"{said}; results kept: {done}" if done else said, first.kind, first.curves)


def analysed_entries(project: Project, folder: Path, kept: Mapping[str, Any]) -> Work:
    """Analyse the entries of a project in the order in which one needs the other; a refused one stops these alone."""
    work = Work()
    blind = False
    for take in sorted(project.recording, key=lambda each: [*ANALYSES].index(each.kind)):
        if blind and take.kind in USE_SENSOR:
            continue  # it would be analysed as if the reading were in newtons
        try:
            key = key_of(take, folder, work.sensor)
            if (earlier := kept.get(key)) is None:
                part = analyse(take, folder, work.sensor)
                work.analysed += 1
            else:
                part = part_of(earlier)
        except FrictionloopError as error:
            work.errors.append((take.kind, error))
            blind |= take.kind == "weights"
            continue
        work.parts.append((key, part))
        work.sensor = _knowing(work.sensor, part)
    return work


def _knowing(sensor: Sensor, part: EntryResult) -> Sensor:
    values = {each.path: each for each in part.measured}
    if (slope := values.get("sensitivity")) is not None:
        sensor = replace(sensor, sensitivity=slope.value, unit=slope.unit.partition("/")[0])
        sensor = replace(sensor, share=slope.error / abs(slope.value))
    if (hertz := values.get("sensor.resonance_hz")) is not None:
        sensor = replace(sensor, resonance_hz=hertz.value)
    if (cutoff := values.get("sensor.cutoff_hz")) is not None:
        sensor = replace(sensor, cutoff_hz=cutoff.value, cutoff_error_hz=cutoff.error)
    return sensor


def results_of(parts: Sequence[tuple[str, EntryResult]]) -> dict[str, Any]:
    """Return what entries told as plain data, by what each depends on."""
    return {key: plain({**part.to_dict(), "curves": part.curves}) for key, part in parts}


def key_of(take: Take, folder: Path, sensor: Sensor) -> str:
    """Return what an analysis depends on, as one hash: files, maps, settings, what is known, version."""
    files = [*take.files, *([take.map] if take.map else [])]
    try:
        prints = [sha256(folder / name) for name in files]
    except OSError as error:
        raise must_be(f"{take.kind}: {error.filename}", error.strerror, "readable") from None
    told = [prints, take.model_dump(), asdict(sensor) if take.kind in USE_SENSOR else {}, package_version(), FORM]
    return hashlib.sha256(json.dumps(told, sort_keys=True, default=str).encode()).hexdigest()


def part_of(tree: Mapping[str, Any]) -> EntryResult:
    """Return an entry from its plain data."""
    return EntryResult(
        measured=tuple(Measured.from_dict(each) for each in tree["measured"]),
        findings=tuple(map(Finding.from_dict, tree["findings"])),
        numbers=dict(tree["numbers"]),
        rows=tuple(map(tuple, tree["rows"])),
        curves=dict(tree["curves"]),
        kind=tree["kind"],
        files=tuple(tree["files"]),
    )
