"""One entry of a project analysed: measured values, findings, and what the certificate draws, all as plain data."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from frictionloop.findings.result import plain
from frictionloop.identification.calibration import hung
from frictionloop.identification.channel_map import ChannelMap
from frictionloop.identification.channel_summary import clipped_share
from frictionloop.identification.finger_entry import amplitude_told, slides_told
from frictionloop.identification.hits_entry import hits_told
from frictionloop.identification.long import Run, Stretches, calm, is_long, means, whole
from frictionloop.identification.opened import Opened, findings_of, opened
from frictionloop.identification.part import Part, Sensor, Told
from frictionloop.identification.plate_entry import carrier_told, delay_told, plate_told, scale_told
from frictionloop.identification.project import Take
from frictionloop.identification.quiet import quiet_told
from frictionloop.identification.recording_columns import READING
from frictionloop.identification.refused import pictured
from frictionloop.identification.response_entry import response_part
from frictionloop.identification.weights_entry import load_told, position_told, weights_told
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.recordings.whole import read_contents

WORK: Mapping[str, Callable[..., Told]] = {
    "weights": weights_told,
    "hits": hits_told,
    "quiet": quiet_told,
    "slides": slides_told,
    "load": load_told,
    "position": position_told,
    "scale": scale_told,
    "plate": plate_told,
    "carrier": carrier_told,
    "delay": delay_told,
    "amplitude": amplitude_told,
}
"""What analyses an entry, by its kind: ``(take, runs, sensor, date) -> Told``."""
IN_PARTS = ("weights", "hits", "quiet", "slides")
"""Kinds of which a long recording is read in parts."""
OVER_TIME = ("hits", "quiet", "slides", "delay", "amplitude")
"""Kinds that no table can give."""
MOST_CLIPPED = 0.01
"""Share of the samples of a recording that may be clipped (assumed)."""


def analyse(take: Take, folder: Path, sensor: Sensor) -> Part:
    """Analyse the recordings of one entry."""
    if take.kind == "response":
        return response_part(take, folder)
    by_file = [_loaded(folder / name, take, folder) for name in take.files]
    files = tuple(
        {"path": name, "sha256": runs[0].attrs["sha256"], "date": take.date or runs[0].attrs["date"]}
        for name, runs in zip(take.files, by_file, strict=True)
    )
    runs = [run for each in by_file for run in each]
    try:
        if take.masses_g is not None:
            runs = [hung(runs, 1e-3 * np.array(take.masses_g))]
        for run in runs:
            _refuse_unfit(run, take.kind)
        told = WORK[take.kind](take, runs, sensor, files[0]["date"])
    except FrictionloopError as refused:
        where = ", ".join(take.files) if len(take.files) < 4 else f"{take.files[0]} and {len(take.files) - 1} more"
        raise pictured(refused, f"{where}: {refused}", take.kind, folder / take.files[0]) from None
    every = [each for run in runs for each in findings_of(run.attrs)]
    found = [each for k, each in enumerate(every) if each not in every[:k]]
    rows, findings = tuple(told.rows), (*found, *told.findings)
    return Part(take.kind, files, tuple(told.measured), findings, plain(told.numbers), rows, told.curves)


def _refuse_unfit(run: Run, kind: str) -> None:
    """Refuse a table where a recording over time is needed, and one that is clipped where no hit can be left out."""
    if isinstance(run, Stretches):
        return
    if kind in OVER_TIME and "row" in run.dims:
        raise must_be(f"{kind}: rows", run.sizes["row"], "samples over time")
    for name in (READING, "load"):
        if kind in ("quiet", "slides", "amplitude") and name in run.data_vars:
            share = clipped_share(np.asarray(run[name].values, dtype=float))
            if share > MOST_CLIPPED:
                raise must_be(f"{name}: share clipped", share, f"at most {MOST_CLIPPED:g}", "", "CLIPPED")


def _loaded(path: Path, take: Take, folder: Path) -> list[Run]:
    """Return the recordings of a file: one, or one for each line of an array whose column is ``name[:, *]``."""
    chart = take.chart(folder)
    columns = {} if chart is None else {name: str(each.column) for name, each in chart.channels.items()}
    if chart is None or not any("*" in column for column in columns.values()):
        return [_run(_opened(path, chart, take), take)]
    masses = None
    if take.kind == "weights" and "*" not in columns.get("mass", "*"):
        one = ChannelMap(channels={"mass": chart.channels["mass"]})
        file = opened(path, one, rate_hz=take.rate_hz, table=True)
        masses = file.part(0, file.rows)["mass"].values
        others = {name: each for name, each in chart.channels.items() if name != "mass"}
        chart = chart.model_copy(update={"channels": others})
    there = {line.name for line in read_contents(path).channels}
    starred = [column for column in columns.values() if "*" in column]
    found: list[Run] = []
    while all(_numbered(column, len(found)) in there for column in starred):
        tree = chart.model_dump()
        for each in tree["channels"].values():
            each["column"] = _numbered(each["column"], len(found))
        found.append(_run(_opened(path, ChannelMap.from_tree(tree), take), take))
    if not found:
        return [_run(_opened(path, chart, take), take)]
    return found if masses is None else [hung(found, masses)]


def _opened(path: Path, chart: ChannelMap | None, take: Take) -> Opened:
    return opened(path, chart, rate_hz=take.rate_hz, resample_hz=take.resample_hz)


def _numbered(column: str | int, k: int) -> str | int:
    """Return the column of recording k, counted from 0; cells and structures of MATLAB count from 1."""
    if isinstance(column, int):
        return column
    return column.replace("{*}", f"{{{k + 1}}}").replace("(*)", f"({k + 1})").replace("*", str(k))


def _run(file: Opened, take: Take) -> Run:
    """Return a recording whole, or of a long one that can be read in parts what its analysis needs."""
    if not is_long(file) or take.kind not in IN_PARTS:
        return whole(file)
    if take.kind == "hits":
        return Stretches(file, "hammer" if "hammer" in file.picked else READING)
    return calm(file, take.interval_s) if take.kind == "quiet" else means(file)
