"""The file that keeps a comparison: one cell per law and condition, with what decided it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.design.comparison.trial_protocol import METRICS, TASKS, Condition
from frictionloop.loop.metrics import METRICS as MEANING
from frictionloop.loop.record import load, save
from frictionloop.loop.sweep_checkpoint import computing
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError, why_unwritable

DIMS = ("law", "speed_mm_s", "slip_length_um", "task")
KIND = "comparison"


@dataclass(frozen=True, eq=False)
class Cell:
    """The metrics of one law under one condition, each over fingers."""

    values: Mapping[str, np.ndarray]
    digest: str
    """Of everything that decides them: system with the law's parameters, fingers, seeds, times, metrics, version."""


class Store:
    """The cells done so far, and the file that keeps them if there is one."""

    def __init__(self, path: str | os.PathLike[str] | None, attrs: Mapping[str, Any]) -> None:
        self.path, self.attrs = path, dict(attrs)
        self.cells: dict[tuple[str, Condition], Cell] = {}
        self.designs: dict[str, dict[str, Any]] = {}
        """What syntheses have found: overrides by a digest of law, bench and code."""

    def resume(self) -> None:
        """Take over the cells of the file; refuse one that keeps another bench or other fingers."""
        if self.path is None:
            raise FrictionloopError("resume: needs path")
        check_writable(self.path)
        if not Path(self.path).exists():
            return
        kept = load(self.path)
        if kept.attrs.get("kind") != KIND:
            raise FrictionloopError(f"{self.path}: keeps no comparison")
        for name, value in self.attrs.items():
            if str(kept.attrs.get(name)) != str(value):
                given = f"{name} = {kept.attrs.get(name)}, not {value}" if name != "system" else "another bench"
                raise FrictionloopError(f"{self.path}: keeps a comparison of {given}")
        try:
            self.cells = cells_of(kept)
            self.designs = dict(json.loads(kept.attrs.get("designs", "{}")))
        except (KeyError, IndexError, TypeError, ValueError, RecursionError) as error:
            said = f"{type(error).__name__}: {error}".splitlines()[0]
            raise FrictionloopError(f"{self.path}: is damaged ({said:.120})") from None

    def design(self, law: str, system: System, work: Callable[[], Mapping[str, Any]]) -> dict[str, Any]:
        """Return what a synthesis finds, or found when the file was written, and keep it."""
        key = sha256("\n".join((law, system.model_dump_json(), computing("analysis", "design"))).encode()).hexdigest()
        if key not in self.designs:
            self.designs[key] = json.loads(json.dumps(dict(work())))
            self.keep()
        return self.designs[key]

    def has(self, law: str, condition: Condition, digest: str) -> bool:
        """Return whether a cell is done; refuse one that is there with other parameters."""
        cell = self.cells.get((law, condition))
        if cell is not None and cell.digest != digest:
            raise FrictionloopError(f"{self.path}: keeps {law} with other parameters or version ({_said(condition)})")
        return cell is not None

    def dataset(self) -> xr.Dataset:
        """Return all cells over law, speed, slip length, task and finger, NaN and no ``digest`` where nothing ran."""
        cells, fingers = self.cells, int(self.attrs["fingers"])
        axes: dict[str, list[Any]] = {
            "law": list(dict.fromkeys(law for law, _ in cells)),
            "speed_mm_s": sorted({at.speed_mm_s for _, at in cells}),
            "slip_length_um": list(dict.fromkeys(at.slip_length_um for _, at in cells)),
            "task": [task for task in TASKS if any(at.task == task for _, at in cells)],
        }
        shape = tuple(len(values) for values in axes.values())
        data = {name: np.full((*shape, fingers), np.nan) for name in METRICS}
        digests = np.full(shape, "", dtype=object)
        for (law, at), cell in cells.items():
            place = tuple(values.index(value) for values, value in zip(axes.values(), (law, *at), strict=True))
            for name, values in cell.values.items():
                data[name][place] = values
            digests[place] = cell.digest
        about = {name: {"units": MEANING[name].units, "long_name": MEANING[name].long_name} for name in METRICS}
        variables: dict[str, Any] = {name: ((*DIMS, "finger"), values, about[name]) for name, values in data.items()}
        variables["digest"] = (DIMS, digests.astype(str))
        coordinates = {name: np.array(values) for name, values in axes.items()}
        for name in ("speed_mm_s", "slip_length_um"):
            coordinates[name] = coordinates[name].astype(float)
        coordinates["finger"] = np.arange(fingers)
        return xr.Dataset(variables, coordinates, {**self.attrs, "kind": KIND})

    def keep(self) -> None:
        """Write the file, if there is one."""
        if self.path is not None:
            save(self.dataset().assign_attrs(designs=json.dumps(self.designs)), self.path)


def cells_of(kept: xr.Dataset) -> dict[tuple[str, Condition], Cell]:
    """Return the cells of a Dataset that are done."""
    found = {}
    digests = kept["digest"].values
    for place in zip(*np.nonzero(digests != ""), strict=True):
        law, speed, z, task = (kept[dim].values[k] for dim, k in zip(DIMS, place, strict=True))
        values = {name: kept[name].values[place] for name in METRICS}
        some = {name: each for name, each in values.items() if not np.isnan(each).all()}
        key = (str(law), Condition(float(speed), float(z), str(task)))
        found[key] = Cell(some, str(digests[place]))
    return found


def check_new(path: str | os.PathLike[str] | None) -> None:
    """Refuse to start over in a file that is there."""
    if path is None:
        return
    if Path(path).exists():
        raise FrictionloopError(f"{path}: exists; --resume (resume=True) continues it")
    check_writable(path)


def check_writable(path: str | os.PathLike[str]) -> None:
    """Refuse a file in whose folder nothing can be written."""
    why = why_unwritable(Path(path).parent)
    if why:
        raise FrictionloopError(f"{path}: cannot be written ({why})")


def _said(condition: Condition) -> str:
    return f"{condition.speed_mm_s:g} mm/s, {condition.slip_length_um:g} um, {condition.task}"
