"""A sweep in parts, a file each in one folder: written by many jobs, read as one result."""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.findings import Result as Answer
from frictionloop.findings.result import Row
from frictionloop.loop.record import load
from frictionloop.loop.sweep_checkpoint import RUNS_DONE, Result, resumed
from frictionloop.loop.sweep_points import units_of
from frictionloop.parameters.toml_reader import check_schema
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.file_integrity import is_sealed, is_usable, is_whole
from frictionloop.quantities.value_checks import whole
from frictionloop.quantities.whole_files import is_held, lock_of

NAMED = re.compile(r"shard-(\d+)-of-(\d+)\.h5")
MOST_SAID = 100_000
"""Values of an axis that each shard says; a longer one counts from 0."""
SAME = ("fingerprint", "code", "shape")
"""Attributes in which the shards of one sweep agree."""


def points_of_shard(shard: tuple[int, int], shape: tuple[int, ...]) -> range:
    """Return the points of part i of n, from 1 on: neighbours, whole rows of the first axis where it has n or more."""
    points = math.prod(shape)
    parts = whole("shard", shard[1], 1, points)
    part, row = whole("shard", shard[0], 1, parts), math.prod(shape[1:]) if shape[0] >= parts else 1
    rows = points // row
    return range((part - 1) * rows // parts * row, part * rows // parts * row)


def shard_file(folder: str | os.PathLike[str] | None, shard: tuple[int, int]) -> Path:
    """Return the file of a part; refuse a folder whose parts are of another number."""
    if folder is None:
        raise must_be("path", None, "the folder of the shards")
    Path(folder).mkdir(parents=True, exist_ok=True)
    _files(folder, shard[1])
    return Path(folder) / f"shard-{shard[0]:0{len(str(shard[1]))}d}-of-{shard[1]}.h5"


def shard_values(path: Path, attrs: Mapping[str, Any], names: tuple[str, ...], empty: np.ndarray) -> np.ndarray:
    """Return what a part has so far, nothing of one that is damaged; refuse a folder with parts of another sweep."""
    others = (each for each in _files(path.parent).values() if each != path and is_sealed(each))
    if (other := next(others, None)) is not None:  # which has looked at another
        _check_same(other, _attrs(other), attrs, ("fingerprint", "code"))
    if not is_usable(path):
        return empty
    return resumed(path, attrs["fingerprint"], attrs["code"], names, empty.shape[1:])


def _attrs(path: Path) -> dict[str, Any]:
    import h5py

    with h5py.File(path) as file:
        return {name: each.item() if getattr(each, "size", 0) == 1 else each for name, each in file.attrs.items()}


def _check_same(path: Path, there: Any, wanted: Any, names: Sequence[str]) -> None:
    for name in names:
        if str(there.get(name)) != str(wanted[name]):
            what = "another sweep" if name != "code" else f"other code, frictionloop {there.get('version')}"
            raise FrictionloopError(f"{path}: is of {what}")


def _files(folder: str | os.PathLike[str], parts: int | None = None) -> dict[int, Path]:
    """Return the files of the parts that are there, by their numbers."""
    named = {path: NAMED.fullmatch(path.name) for path in sorted(Path(folder).glob("shard-*.h5"))}
    found = {path: (int(each[1]), int(each[2])) for path, each in named.items() if each}
    for path, (_, of) in found.items():
        parts = parts or of
        if of != parts:
            raise FrictionloopError(f"{path}: is one of {of} shards, not of {parts}")
    return {part: path for path, (part, _) in found.items()}


class ShardResult(Result):
    """The growing result of a part of a sweep: runs in their order, numbered as those of the whole."""

    def __init__(self, *given: Any, own: range, shard: tuple[int, int]) -> None:
        super().__init__(*given)
        self.own, seeds = own, self.grid.seeds
        axes = {path: [*axis.tolist()] if axis.size < MOST_SAID else axis.size for path, axis in self.grid.axes.items()}
        self.attrs = self.attrs | {
            "shard": shard[0], "shards": shard[1], "shape": json.dumps(self.grid.shape),
            "axes": json.dumps(axes), "seeds": json.dumps(seeds),
        }  # fmt: skip

    def dataset(self) -> xr.Dataset:
        """Return the metrics over ``run``, NaN where nothing has run."""
        seeds = len(self.grid.seeds)
        runs = xr.Variable("run", np.arange(self.own.start * seeds, self.own.stop * seeds))
        data = self.variables(("run",), (runs.size,))
        columns = {} if self.grid.gridded else self.grid.columns("point", self.own)
        return xr.Dataset(data, {**columns, "run": runs}, self.attrs | {RUNS_DONE: self.done})


STATES = ("done", "running", "unfinished", "damaged", "missing")


class SweepStatus(Answer, schema="sweep.status/1"):
    """How far the shards of a sweep are."""

    shards: int
    done: tuple[int, ...]
    running: tuple[int, ...]
    """Those that a process writes now."""
    unfinished: tuple[int, ...]
    """Those that were stopped."""
    damaged: tuple[int, ...]
    missing: tuple[int, ...]
    runs_done: int
    runs: int

    def rows(self) -> list[Row]:
        """Return how many shards and runs are done, and which are not."""
        found = [("done", f"{len(self.done)} of {self.shards} shards, {self.runs_done:,} of {self.runs:,} runs")]
        return found + [(state, _spans(getattr(self, state))) for state in STATES[1:] if getattr(self, state)]


def _spans(numbers: Sequence[int]) -> str:
    """Return numbers as a job array takes them: 3,7-9."""
    spans: list[list[int]] = []
    for each in numbers:
        if spans and spans[-1][-1] == each - 1:
            spans[-1] = [spans[-1][0], each]
        else:
            spans.append([each])
    return ",".join("-".join(map(str, span)) for span in spans)


def sweep_status(folder: str | os.PathLike[str]) -> SweepStatus:
    """Return which shards of a sweep are done, running, stopped, damaged or missing.

    Parameters
    ----------
    folder
        Where ``sweep(..., shard=(i, n))`` has put them.

    Raises
    ------
    FrictionloopError
        For a folder without shards, or with shards of different sweeps.
    """
    files, attrs = together(folder)
    parts, kinds = _parts(files), dict[str, list[int]]()
    done = 0
    for part in range(1, parts + 1):
        there = attrs.get(part)
        done += int(there[RUNS_DONE]) if there else 0
        kinds.setdefault(_state(files.get(part), there), []).append(part)
    shape = _shape(attrs)
    of: dict[str, Any] = {name: tuple(kinds.get(name, ())) for name in STATES}
    return SweepStatus(shards=parts, runs_done=done, runs=math.prod(shape), **of)


def _state(path: Path | None, attrs: Mapping[str, Any] | None) -> str:
    if path is None:
        return "missing"
    lock = lock_of(path)
    if lock.exists() and is_held(lock):
        return "running"
    if attrs is None or not is_whole(path):
        return "damaged"
    part = points_of_shard((int(attrs["shard"]), int(attrs["shards"])), _shape({0: attrs})[:-1])
    return "done" if attrs[RUNS_DONE] >= len(part) * _shape({0: attrs})[-1] else "unfinished"


def _parts(files: Mapping[int, Path]) -> int:
    named = NAMED.fullmatch(next(iter(files.values())).name)
    assert named is not None
    return int(named[2])


def _shape(attrs: Mapping[int, Mapping[str, Any]]) -> tuple[int, ...]:
    return tuple(json.loads(next(iter(attrs.values()))["shape"]))


def together(folder: str | os.PathLike[str], told: bool = False) -> tuple[dict[int, Path], dict[int, dict[str, Any]]]:
    """Return the files of the parts, and the attributes of those that can be read; refuse parts of different sweeps."""
    files, attrs = _files(folder), dict[int, dict[str, Any]]()
    for part, path in files.items():
        with suppress(OSError):
            attrs[part] = _attrs(path)
    if not attrs:
        raise FrictionloopError(f"{folder}: has no shards")
    first = next(iter(attrs.values()))
    check_schema(int(first["schema"]), f"{folder}: ")
    for part, each in attrs.items():
        _check_same(files[part], each, first, SAME)
    if told and (lost := [part for part in files if part not in attrs]):
        warnings.warn(f"{folder}: cannot read shards {_spans(lost)}", stacklevel=3)
    return files, attrs


def coordinates_of(attrs: Mapping[str, Any]) -> dict[str, Any]:
    """Return the axes that each part says, without the seeds."""
    axes = json.loads(attrs["axes"])
    whole_of = {name: np.arange(each) if isinstance(each, int) else each for name, each in axes.items()}
    return {name: xr.Variable(name, each, units_of(name)) for name, each in whole_of.items()}


def open_sweep(folder: str | os.PathLike[str]) -> xr.Dataset:
    """Return the shards of a sweep as one result, NaN where nothing has run.

    With Dask installed (the extra ``cluster``) values are read where they are asked for.

    Parameters
    ----------
    folder
        Where ``sweep(..., shard=(i, n))`` has put them; whole or not.

    Returns
    -------
    xarray.Dataset
        As of `sweep`, bit for bit. A damaged shard counts as not there; `sweep_status` names it.

    Raises
    ------
    FrictionloopError
        For a folder without shards, or with shards of different sweeps.
    """
    files, attrs = together(folder, told=True)
    first, shape, parts = next(iter(attrs.values())), _shape(attrs), _parts(files)
    coords, seeds = coordinates_of(first), json.loads(first["seeds"])
    axes = tuple(coords)
    sizes = [len(points_of_shard((part, parts), shape[:-1])) for part in range(1, parts + 1)]
    there = {part: files[part] for part in attrs}
    any_part = load(next(iter(there.values())))
    data = {}
    for name, values in any_part.data_vars.items():
        joined = _joined(there, str(name), [size * shape[-1] for size in sizes], shape, float)
        data[str(name)] = xr.Variable((*axes, "seed"), joined, values.attrs)
    for name, values in any_part.coords.items():
        if name != "run":
            joined = _joined(there, str(name), sizes, shape[:1], values.dtype)
            coords[str(name)] = xr.Variable(axes[0], joined, values.attrs)
    done = sum(int(each[RUNS_DONE]) for each in attrs.values())
    kept = {name: value for name, value in first.items() if name not in OWN}
    return xr.Dataset(data, coords | {"seed": seeds}, kept | {RUNS_DONE: done})


OWN = ("shard", "shards", "shape", "axes", "seeds", "coordinates", "_NCProperties", RUNS_DONE)
"""Attributes of the file of a shard that the whole has not, or anew."""


def _joined(files: Mapping[int, Path], name: str, sizes: Sequence[int], shape: tuple[int, ...], dtype: Any) -> Any:
    """Return one variable of all parts in its shape, lazily where Dask is installed."""
    inner = () if any(size % math.prod(shape[1:]) for size in sizes) else shape[1:]
    if len(files) < len(sizes) and np.dtype(dtype).kind in "iu":
        dtype = float  # a whole number has no NaN
    pieces = [_Piece(files.get(part), name, size, inner, dtype) for part, size in enumerate(sizes, 1)]
    try:
        import dask.array as da
    except ImportError:
        return np.concatenate([piece() for piece in pieces]).reshape(shape)
    label = f"{name}-{hashlib.sha256(repr(pieces).encode()).hexdigest()}"
    graph = {(label, k, *[0] * len(inner)): (piece,) for k, piece in enumerate(pieces)}
    chunks = (tuple(size // math.prod(inner) for size in sizes), *((each,) for each in inner))
    array: Any = da.Array
    return array(graph, label, chunks, dtype).reshape(shape)


class _Piece(NamedTuple):
    """One variable of one part, read when it is called."""

    path: Path | None
    name: str
    size: int
    row: tuple[int, ...]
    dtype: Any

    def __call__(self) -> Any:
        import h5py

        if self.path is None:
            values = np.full(self.size, np.nan if np.dtype(self.dtype).kind == "f" else "", self.dtype)
        else:
            with h5py.File(self.path) as file:
                values = file[self.name][...].astype(self.dtype)
        return values.reshape((-1, *self.row)) if self.row else values
