"""For how many people a set-point can be rendered, how well, and who they are."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from operator import attrgetter
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.analysis.operating_point import RECORDED
from frictionloop.analysis.stability import NEAR
from frictionloop.design import controller_findings
from frictionloop.design.grid_corners import peak_of
from frictionloop.design.people_reach import PeopleReach, moist_later, people_reach, share_of_all, with_own
from frictionloop.design.population_margins import unlike
from frictionloop.design.sweep_summary import SMALL, GridResult, loss_of, without_value
from frictionloop.findings import Finding, shown
from frictionloop.findings.result import Row, Table, Tables, frame, plain
from frictionloop.findings.shown import between
from frictionloop.loop.companion_runs import OPEN_ERROR, OPENED
from frictionloop.loop.record import save
from frictionloop.loop.sweep import SweepInterrupted, sweep
from frictionloop.loop.sweep_checkpoint import runs_done
from frictionloop.parameters import System
from frictionloop.parameters.doubtful_values import of_ceiling
from frictionloop.physics.fingers import Fingers, coefficient_of, fingers_for
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.class_help import Brief

METRICS = ("r2_identity", "rms_error", "saturation_index", "perceptual_index")
"""Kept of people if none are named, and ``disturbance_left`` of a recorded disturbance."""
WORST = 0.9
"""The worst decile begins where this share of the fingers is better, or as good."""
PARTS = 4
"""Parts of the people, by their coefficient."""
OF_EACH = {
    "coefficient": "coefficient",
    "motion.load_n": "load, N",
    "lowest_n": "lowest, N",
    "highest_n": "highest, N",
    "served": "served",
}
"""What is shown of each finger beside its metrics, and its head."""
NUMBER = "motion.person"
"""What numbers a finger, and describes nothing."""


class People(GridResult, schema="people/1", without="people reach"):
    """For how many people a set-point can be rendered, and how well."""

    people: Fingers
    """Overrides, one finger each."""
    drawn: Mapping[str, Any]
    """What `fingers_for` was given for them."""
    duration_s: float
    """Of each run. ``grid`` has over ``finger`` each one's ``coefficient``, ``lowest_n``, ``highest_n``, whether it is
    ``capable`` of the set-point, ``capable_load_moves`` and ``served`` in ordinary use."""
    reach: PeopleReach | None
    """Who can be given the set-point; None if that is not known."""

    @property
    def served(self) -> int | None:
        """How many can be given the set-point in ordinary use."""
        return None if self.reach is None else int(self.reach.served.sum())

    @property
    def share(self) -> tuple[float, float] | None:
        """Its share of all such people, 95 % interval."""
        return None if self.served is None else share_of_all(self.served, len(self.people))

    def spread(self, metric: str, some: np.ndarray | None = None) -> dict[str, float]:
        """Return median and worst decile over fingers (of ``some``), each by its mean over seeds, and their number."""
        values = self.grid[metric].transpose("finger", "seed").values
        count = np.sum(~np.isnan(values), axis=1)
        mean = np.nansum(values, axis=1)[count > 0] / count[count > 0]
        if some is not None:
            mean = mean[some[count > 0]]
        if mean.size == 0:
            return {"median": math.nan, "worst_decile": math.nan, "fingers": 0}
        worst_last = mean[np.argsort(loss_of(metric, mean), kind="stable")]
        at = math.ceil(WORST * mean.size - 1e-9) - 1
        return {"median": float(np.median(mean)), "worst_decile": float(worst_last[at]), "fingers": mean.size}

    def _some(self) -> np.ndarray | None:
        """Return who is served; None where that is nobody, or not known."""
        return self.reach.served if self.reach is not None and self.served else None

    def rows(self) -> list[Row]:
        """Return for how many, what is asked, what is left, and who they are."""
        found = []
        if self.reach is not None and self.share is not None:
            low, high = (f"{100 * each:.0f}" for each in self.share)
            found.append(("serves", f"{self.served} of {len(self.people)} people; of all such {low} to {high} %"))
            too = [(~self.reach.low, "low"), (~self.reach.high, "high")]
            short = ", ".join(f"too {way} for {int(who.sum())}" for who, way in too)
            found.append(("asked", f"{between(self.reach.low_n, self.reach.high_n, 'N')}, {short}"))
        if "rms_error" in self.grid:
            found.append(("leaves", self._left()))
        motion: Any = self.system.motion
        loads = [each["motion.load_n"] for each in with_own(self.system, self.people)]
        ends = self.grid["coefficient"].values
        who = (
            f"coefficient {between(float(ends.min()), float(ends.max()))}, load {between(min(loads), max(loads), 'N')}"
        )
        found.append(("people", f"{who}, {shown(motion.speed_mm_s)} mm/s"))
        found.append(self._runs(f"{len(self.people)} people"))
        return found

    def _left(self) -> str:
        some = self._some()
        loop, opened = (self.spread(name, some) if name in self.grid else {} for name in ("rms_error", OPEN_ERROR))

        def of(key: str, unit: str = "") -> str:
            return f"{shown(1e3 * loop[key])}{unit}" + (f" of {shown(1e3 * opened[key])}" if opened else "")

        return f"{of('median', ' mN rms')}{' in open loop' * bool(opened)}; worst decile {of('worst_decile')}"

    def tables(self) -> Tables:
        """Return metrics over people, who is able when, the same by coefficient, what they replace, and each finger."""
        reach = {} if self.reach is None else {"able": self.reach.table()}
        return {
            "metrics": self._metrics(),
            **reach,
            "by coefficient": self.by_coefficient(),
            "in place of the file's": self._replaced(),
            "each": self._each(),
        }

    def _metrics(self) -> Table:
        some, rows = self._some(), {}
        for name in map(str, self.grid.data_vars):
            if np.any(np.isfinite(self.grid[name].values)):
                factor, unit = SMALL.get(str(self.grid[name].attrs.get("units")), (1.0, ""))
                groups = [self.spread(name), *([] if some is None else [self.spread(name, some)])]
                cells = [factor * each[key] for each in groups for key in ("median", "worst_decile")]
                rows[f"{name}, {unit}" if unit else name] = [*cells, groups[0]["fingers"]]
        heads = ["median", "worst decile", *([] if some is None else ["served: median", "worst decile "]), "of"]
        return frame(rows, "", heads)

    def by_coefficient(self) -> Table:
        """Return how many are served, and the median error, of people by parts of their friction coefficients."""
        order = np.argsort(self.grid["coefficient"].values, kind="stable")
        rows = {}
        for part in (each for each in np.array_split(order, PARTS) if each.size):
            here = self.grid.isel(finger=part)
            values = here["coefficient"].values
            row: dict[str, Any] = {"people": part.size}
            row |= {} if self.reach is None else {"served": int(self.reach.served[part].sum())}
            errors = [name for name in ("rms_error", OPEN_ERROR) if name in here]
            row |= {f"{name}, mN": 1e3 * float(here[name].mean("seed").median()) for name in errors}
            rows[between(float(values.min()), float(values.max()))] = row
        return frame(rows, "coefficient")

    def _each(self) -> Table:
        frame = self.grid.mean("seed").to_dataframe()
        own = [name for name in OF_EACH if name in frame]
        return frame[[*own, *(name for name in self.grid.data_vars)]].rename(columns=OF_EACH)

    @property
    def replaced(self) -> dict[str, Any]:
        """The system's own values that each finger replaces, by dotted name."""
        return {path: attrgetter(path)(self.system) for path in self.people[0] if path != NUMBER}

    def _replaced(self) -> Table:
        rows = {}
        for path, own in self.replaced.items():
            values = np.array([each[path] for each in self.people])
            rows[path] = [own, values.min(), np.median(values), values.max()]
        heads = ["file", "least", "median", "largest"]
        return frame(rows, "", heads).astype(float)

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name, each finger's metrics too."""
        names, who = list(map(str, self.grid.data_vars)), self._some()
        each = {str(name): values.values for name, values in self.grid.coords.items() if values.dims == ("finger",)}
        del each["finger"]
        reach = self.reach
        return super().to_dict() | plain(
            {
                "served": self.served,
                "share": self.share,
                "asked_n": None if reach is None else [reach.low_n, reach.high_n],
                "reach": None if reach is None else vars(reach),
                "population": {name: self.spread(name) for name in names},
                "population_served": None if who is None else {name: self.spread(name, who) for name in names},
                "replaced": self.replaced,
                "each": each,
            }
        )


class PeopleInterrupted(KeyboardInterrupt, metaclass=Brief):
    """Ctrl-C while people are looked at; ``partial``, a result of `people`, is what was found until then."""

    def __init__(self, partial: Any) -> None:
        super().__init__("people interrupted")
        self.partial = partial


def people(
    system: System,
    count: int = 100,
    seed: int = 0,
    population: Mapping[str, Any] | str | os.PathLike[str] | None = None,
    loads_n: tuple[float, float] | None = None,
    coefficients: tuple[float, float] | None = None,
    duration_s: float = 10.0,
    *,
    seeds: int | Sequence[int] = 1,
    metrics: Sequence[str] | None = None,
    given: Sequence[str] = (),
    path: str | os.PathLike[str] | None = None,
    **options: Any,
) -> People:
    """Return for how many people the set-point of a system can be rendered, and how well.

    Parameters
    ----------
    system
        The bench with its controller; finger, load and tremor are those of each person.
    count, seed, population, loads_n, coefficients
        The people, as of `fingers_for`.
    duration_s, seeds, metrics
        As of `sweep`. Without ``metrics``: r2_identity, rms_error, saturation_index, perceptual_index.
    given
        As of `fingers_for`.
    path, options
        As of `sweep`.

    Raises
    ------
    FrictionloopError
        As `fingers_for` and `sweep`.
    PeopleInterrupted
        On Ctrl-C, carrying what was found until then.
    """
    if "shard" in options:
        raise must_be("shard", options["shard"], "of sweep, for people too")
    drawn = fingers_for(system, count, seed, population, loads_n, coefficients, given=given)
    names = metrics_for(system) if metrics is None else metrics
    try:
        grid = sweep(system, drawn, duration_s, seeds, names, path=path, **options)
    except SweepInterrupted as stop:
        raise PeopleInterrupted(_of(system, drawn, stop.partial, path, [])) from None
    how: dict[str, Any] = {name: options[name] for name in ("score_from_s", "n_jobs", "progress") if name in options}
    more: list[Finding] = []
    try:
        grid = _with_open_loop(grid, system, drawn, duration_s, seeds, how)
    except FrictionloopError as why:  # a run without a number, say
        more.append(Finding("METRIC-NONE", value=[OPEN_ERROR], more={"reason": str(why)}))
    except KeyboardInterrupt:  # what was swept is not lost for it
        raise PeopleInterrupted(_of(system, drawn, grid, path, more)) from None
    return _of(system, drawn, grid, path, more)


def metrics_for(system: System) -> list[str]:
    """Return the metrics that are kept of people if none are named."""
    return [*METRICS, *["disturbance_left"] * (system.disturbance.kind in RECORDED)]


def _with_open_loop(
    grid: xr.Dataset, system: System, drawn: Fingers, duration_s: float, seeds: Any, how: Mapping[str, Any]
) -> xr.Dataset:
    """Return the result with the error of the lookup table alone beside that of the loop, where there is one."""
    if "rms_error" not in grid or system.controller.kind == OPENED["controller.kind"]:
        return grid
    opened = sweep(system.evolve(OPENED), drawn, duration_s, seeds, ["rms_error"], **how)
    error = opened["rms_error"].rename(OPEN_ERROR).assign_attrs(long_name="rms error in open loop")
    names = [str(name) for name in grid.data_vars]
    at = names.index("rms_error") + 1
    return grid.assign({OPEN_ERROR: error})[[*names[:at], OPEN_ERROR, *names[at:]]]


def _of(system: System, drawn: Fingers, grid: xr.Dataset, path: Any, more: list[Finding]) -> People:
    """Return what was found, and keep it in the file of the sweep."""
    done, total, duration_s = runs_done(grid), len(drawn) * grid.sizes["seed"], float(grid.attrs["duration_s"])
    band, found = people_reach(system, drawn, duration_s)
    reach = found if isinstance(found, PeopleReach) else None
    ends = {"lowest_n": band.low_n, "highest_n": band.high_n}
    coords: dict[str, Any] = {name: ("finger", values, {"units": "N"}) for name, values in ends.items()}
    coords["coefficient"] = ("finger", [coefficient_of(each) for each in with_own(system, drawn)])
    if reach is not None:
        coords |= {"capable": ("finger", reach.able), "capable_load_moves": ("finger", reach.moving)}
        coords["served"] = ("finger", reach.served)
    grid = grid.assign_coords(coords)
    if path is not None:
        save(grid, path)
    told = [
        *([] if done == total else [Finding("STOPPED", value=done, limit=total)]),
        *unlike(system, drawn),
        *([found] if isinstance(found, Finding) else moist_later(found)),
        *own_loop(system),
        *without_value(system, grid),
        *controller_findings.of_signals(system),
        *of_ceiling(system),
        *more,
    ]
    return People(
        system=system,
        people=drawn,
        drawn=drawn.drawn,
        duration_s=duration_s,
        grid=grid,
        reach=reach,
        runs=total,
        runs_done=done,
        findings=tuple(told),
    )


def own_loop(system: System) -> Iterator[Finding]:
    """Yield that the loop rings, or nearly does, on the finger of the system itself."""
    peak = peak_of(system)
    if peak >= NEAR:
        yield Finding("OWN-RINGS", value=peak, limit=NEAR, remedy="frictionloop design controller")
