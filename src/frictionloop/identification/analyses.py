"""One entry of a project analysed: measured values, sentences, and what the certificate draws, all as plain data."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from frictionloop.identification.channel_map import ChannelMap
from frictionloop.identification.channels import READING
from frictionloop.identification.clipping import clipped_share
from frictionloop.identification.hung import hung
from frictionloop.identification.long import Run, Stretches, calm, is_long, means, whole
from frictionloop.identification.opened import Opened, opened
from frictionloop.identification.parts.hits import hits_part
from frictionloop.identification.parts.part import Found, Part, Sensor
from frictionloop.identification.parts.quiet import quiet_part
from frictionloop.identification.parts.response import response_part
from frictionloop.identification.parts.slides import slides_part
from frictionloop.identification.parts.weights import weights_part
from frictionloop.identification.project import Take
from frictionloop.identification.refused import pictured
from frictionloop.identification.takes import TAKES
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.whole import read_contents

WORK: Mapping[str, Callable[..., Found]] = {
    "weights": weights_part,
    "hits": hits_part,
    "quiet": quiet_part,
    "slides": slides_part,
    **TAKES,
}
"""What analyses an entry, by its kind."""
OVER_TIME = ("hits", "quiet", "slides", "delay", "amplitude")
"""Kinds that no table can give."""
MOST_CLIPPED = 0.01
"""Share of the samples of a recording that may be clipped (assumed)."""


def analyse(take: Take, folder: Path, sensor: Sensor) -> Part:
    """Analyse the recordings of one entry.

    Raises
    ------
    FrictionloopError
        For what a file or an analysis refuses, naming the file.
    """
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
        values, told, rows, curves = WORK[take.kind](take, runs, sensor, files[0]["date"])
    except FrictionloopError as refused:
        where = ", ".join(take.files) if len(take.files) < 4 else f"{take.files[0]} and {len(take.files) - 1} more"
        raise pictured(refused, f"{where}: {refused}", take.kind, folder / take.files[0]) from None
    told = list(dict.fromkeys([*(line for run in runs for line in run.attrs["told"].splitlines()), *told]))
    return Part(take.kind, files, tuple(values), tuple(told), tuple(rows), curves)


def _refuse_unfit(run: Run, kind: str) -> None:
    """Refuse a table where a recording over time is needed, and one that is clipped where no hit can be left out."""
    if isinstance(run, Stretches):
        return
    if kind in OVER_TIME and "row" in run.dims:
        raise FrictionloopError(f"holds {run.sizes['row']} rows without times: {kind} need a recording over time")
    for name in (READING, "load"):
        if kind in ("quiet", "slides", "amplitude") and name in run.data_vars:
            share = clipped_share(np.asarray(run[name].values, dtype=float))
            if share > MOST_CLIPPED:
                raise FrictionloopError(
                    f"{name!r} is clipped in {share:.1%} of its samples: must be at most {MOST_CLIPPED:.0%}"
                )


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
    if not is_long(file) or take.kind in TAKES:
        return whole(file)
    if take.kind == "hits":
        return Stretches(file, "hammer" if "hammer" in file.picked else READING)
    return calm(file, take.interval_s) if take.kind == "quiet" else means(file)
