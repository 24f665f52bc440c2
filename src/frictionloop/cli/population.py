"""A sweep over a population of fingers: who can be given the set-point at all, and how well most of them are."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from pydantic import BaseModel

from frictionloop.analysis.levels import RECORDED
from frictionloop.cli import advice, advice_text, describe, ringing, screen, served
from frictionloop.cli.flags import overrides_of
from frictionloop.cli.outcome import Outcome, left_out, loss_of, shown
from frictionloop.cli.population_reach import Reach, reach_of
from frictionloop.cli.recorded_units import beside_able
from frictionloop.cli.replaced import replaced, replaced_said, unlike
from frictionloop.parameters import FingerFriction, Skin, Strokes, System
from frictionloop.physics.fingers import Fingers, fingers
from frictionloop.quantities import FrictionloopError

METRICS = ("r2_identity", "rms_error", "saturation_index", "perceptual_index")
"""Kept of a population if none are named, and ``disturbance_left`` of a recorded disturbance."""
WORST = 0.9
"""The worst decile begins where this share of the fingers is better, or as good."""


def population_of(
    system: System,
    count: int,
    seed: int,
    flags: Iterable[str] | None,
    measured: Path | None = None,
    loads_n: tuple[float, float] | None = None,
) -> Fingers:
    """Return the fingers to sweep, of a measured population if there is one.

    Refuses a system without a finger, and flags that each finger would replace.
    """
    wanted: dict[str, type[BaseModel]] = {"friction": FingerFriction, "finger": Skin, "motion": Strokes}
    for block, model in wanted.items():
        if not isinstance(getattr(system, block), model):
            kind = model.model_fields["kind"].default
            raise FrictionloopError(
                f'fingers = {count}: needs {block}.kind = "{kind}", not "{getattr(system, block).kind}"; '
                "--preset bench has all that a finger needs"
            )
    people = fingers(count, seed, None if measured is None else str(measured), loads_n)
    for path in overrides_of(flags):
        if path in people[0]:
            more = "; --loads 0.4,1.2 gives them a range" if path == "motion.load_n" else ""
            raise FrictionloopError(f"{path}: every one of --fingers brings its own; leave it out{more}")
    return people


MARGINS = (
    "errors are of these runs, also of fingers on which the loop may ring:",
    "`frictionloop design check FILE --fingers 100` counts them, with margins",
)


def metrics_of(system: System) -> list[str]:
    """Return the metrics that are kept of a population if none are named."""
    return [*METRICS, *["disturbance_left"] * (system.disturbance.kind in RECORDED)]


class Population(Outcome):
    """A result of ``sweep`` over fingers."""

    def __init__(self, result: xr.Dataset, elapsed_s: float, complete: bool, system: System, people: Fingers) -> None:
        super().__init__(result, elapsed_s, complete)
        # Sweeps keep what they were given; the duration is that of each run.
        duration_s = float(result.attrs["duration_s"])
        band, found = reach_of(system, people, duration_s)
        self.reach: Reach | None = None if isinstance(found, str) else found
        self._unknown = found if isinstance(found, str) else ""
        more: dict[str, Any] = {name: band[name] for name in ("lowest_n", "highest_n")}
        if self.reach is not None:
            more |= {"capable": ("finger", self.reach.able), "capable_load_moves": ("finger", self.reach.moving)}
            more["served"] = ("finger", self.reach.served)
        self.result = result.assign_coords(more)
        self._beside, self._slide = beside_able(system), slide_said(system)
        self._others = unlike(system, people)
        self._replaced = (replaced(system, people), replaced_said(system, people))
        self._median = {name: self.spread(name)["median"] if name in result else math.nan for name in advice.SIGNS}
        self.rings = advice.of_population(system, self._median["r2_identity"], duration_s) if complete else None

    def spread(self, metric: str, some: np.ndarray | None = None) -> dict[str, float]:
        """Return median and worst decile over fingers (of ``some``), each by its mean over seeds, and their number."""
        values = self.result[metric].transpose("finger", "seed").values
        count = np.sum(~np.isnan(values), axis=1)
        mean = np.nansum(values, axis=1)[count > 0] / count[count > 0]
        if some is not None:
            mean = mean[some[count > 0]]
        if mean.size == 0:
            return {"median": math.nan, "worst_decile": math.nan, "fingers": 0}
        worst_last = mean[np.argsort(loss_of(metric, mean), kind="stable")]
        at = math.ceil(WORST * mean.size - 1e-9) - 1
        return {"median": float(np.median(mean)), "worst_decile": float(worst_last[at]), "fingers": mean.size}

    def _served(self) -> np.ndarray | None:
        return None if self.reach is None else self.reach.served

    def summary(self, duration_s: float) -> list[Any]:
        """Return what a person is shown."""
        who, total = self._served(), self.result.sizes["finger"]
        some_of: tuple[str, ...] = ()
        those = ""
        if who is not None and 0 < who.sum() < total:
            some_of = (f"of the {int(who.sum())}: median", "worst decile")
            those = f"; the {int(who.sum())} are those below"
        rows: list[describe.Row] = [("", "median", "worst decile", *some_of, "")]
        without, some = left_out(self.result), []
        for name, values in self.result.data_vars.items():
            if name in without:
                continue
            everyone, units = self.spread(str(name)), values.attrs.get("units", "1")
            groups = [everyone, *([self.spread(str(name), who)] if some_of else [])]
            cells = [_cell(each[key], units) for each in groups for key in ("median", "worst_decile")]
            rows.append((str(name), *cells, ""))
            if everyone["fingers"] < total:
                some.append(f"{name} is that of {everyone['fingers']} fingers; the others have none")
        of = f"{total} finger{'s' * (total > 1)}" + (f" x {self.seeds} seeds" if self.seeds > 1 else "")
        return [
            *([screen.wrapped(self._others), ""] if self._others else []),
            screen.table(rows, whole=True),
            *some,
            *without.values(),
            f"worst decile: nine fingers in ten do as well or better{those}",
            *(
                ["perceptual_index: f_a - f_r in thresholds of touch; less is better"]
                * ("perceptual_index" in self.result)
            ),
            "",
            *self._reach_lines(total),
            screen.wrapped(self._replaced[1]),
            "",
            *([*advice_text.lines(self.rings, self._median), ""] if self.rings else []),
            self.work(of, duration_s),
        ]

    def _reach_lines(self, total: int) -> list[Any]:
        reach = self.reach
        if reach is None:
            return [screen.wrapped(f"which fingers can be given the set-point is not known: {self._unknown}")]
        return [*served.lines(reach, total), *self._beside, *self._slide]

    def as_json(self) -> dict[str, Any]:
        """Return everything: each finger's metrics and reach, and what the summary says."""
        who, found = self._served(), super().as_json()
        del found["best"]
        names = [str(name) for name in self.result.data_vars]
        found["population"] = {name: self.spread(name) for name in names}
        found["lowest_n"], found["highest_n"] = self.result["lowest_n"].values, self.result["highest_n"].values
        found |= served.as_json(self.reach) | {"replaced": self._replaced[0]}
        found["ringing"] = ringing.as_json(self.rings)
        if who is not None:
            found["population_served"] = {name: self.spread(name, who) for name in names}
        return found


def slide_said(system: System) -> list[str]:
    """Return at which speed all fingers slide, and the flag for others."""
    motion = system.motion
    if not (isinstance(motion, Strokes) and isinstance(system.finger, Skin)):
        return []
    return [f"all slide at {motion.speed_mm_s:g} mm/s (--motion.speed_mm_s)", *MARGINS]


def _cell(value: float, units: str) -> str:
    return "-" if math.isnan(value) else shown(value, units)
