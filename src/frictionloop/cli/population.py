"""A sweep over a population of fingers: who can be given the set-point at all, and how well most of them are."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from pydantic import BaseModel

from frictionloop.analysis.levels import at_levels
from frictionloop.analysis.operating import asked
from frictionloop.cli import advice, advice_text, describe, ringing, screen
from frictionloop.cli.describe import finger_values
from frictionloop.cli.flags import overrides_of
from frictionloop.cli.outcome import Outcome, loss_of, shown
from frictionloop.cli.replaced import replaced, replaced_said
from frictionloop.cli.scores import between
from frictionloop.parameters import FingerFriction, Skin, Strokes, System
from frictionloop.physics.capable import capable
from frictionloop.physics.fingers import Fingers, fingers
from frictionloop.quantities import FrictionloopError

METRICS = ("r2_identity", "rms_error", "saturation_index", "perceptual_index")
"""Kept of a population if none are named."""
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


class Reach(NamedTuple):
    """Which fingers can be given the lowest and the highest force that a set-point asks for."""

    low_n: float
    high_n: float
    hold_s: float
    low: np.ndarray
    high: np.ndarray
    moving: np.ndarray
    """Who can be given both for all but a twentieth of the time while the load drifts and trembles."""

    @property
    def able(self) -> np.ndarray:
        """Who can be given both with the load at its mean."""
        able: np.ndarray = self.low & self.high
        return able


def reach_of(system: System, people: Fingers, duration_s: float) -> tuple[xr.Dataset, Reach | None]:
    """Return lowest_n and highest_n of each finger, held as long as it touches, and who reaches the set-point.

    A recorded set-point is as low and as high as its samples. None for one whose level is not known, from outside.
    """
    contact_s: float = system.motion.contact_s  # type: ignore[union-attr]
    hold_s = min(contact_s, duration_s) if contact_s > 0 else duration_s
    own = finger_values(system)
    touching, plate_um = [own | each for each in people], system.plate.max_amplitude_um
    band, moved = (
        capable(touching, max_amplitude_um=plate_um, contact_s=hold_s, load_moves=moves) for moves in (False, True)
    )
    try:
        wanted = asked(at_levels(system))
    except FrictionloopError:
        return band, None
    low, high, moved_low, moved_high = (
        found
        for each in (band, moved)
        for found in (each["lowest_n"].values <= wanted.low_n, each["highest_n"].values >= wanted.high_n)
    )
    return band, Reach(wanted.low_n, wanted.high_n, hold_s, low, high, moved_low & moved_high)


class Population(Outcome):
    """A result of ``sweep`` over fingers."""

    def __init__(self, result: xr.Dataset, elapsed_s: float, complete: bool, system: System, people: Fingers) -> None:
        super().__init__(result, elapsed_s, complete)
        # Sweeps keep what they were given; the duration is that of each run.
        duration_s = float(result.attrs["duration_s"])
        band, self.reach = reach_of(system, people, duration_s)
        more: dict[str, Any] = {name: band[name] for name in ("lowest_n", "highest_n")}
        if self.reach is not None:
            more["capable"] = ("finger", self.reach.able)
        self.result = result.assign_coords(more)
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

    def _able(self) -> np.ndarray | None:
        return None if self.reach is None else self.reach.able

    def summary(self, duration_s: float) -> list[Any]:
        """Return what a person is shown."""
        able, total = self._able(), self.result.sizes["finger"]
        split = able is not None and 0 < able.sum() < total
        rows: list[describe.Row] = [
            ("", "median", "worst decile", *(("able: median", "worst decile") if split else ()), "")
        ]
        for name, values in self.result.data_vars.items():
            everyone, units = self.spread(str(name)), values.attrs.get("units", "1")
            groups = [everyone, self.spread(str(name), able)] if split else [everyone]
            cells = [_cell(each[key], units) for each in groups for key in ("median", "worst_decile")]
            some = "" if everyone["fingers"] == total else f"of {everyone['fingers']} fingers"
            rows.append((str(name), *cells, some))
        of = f"{total} finger{'s' * (total > 1)}" + (f" x {self.seeds} seeds" if self.seeds > 1 else "")
        return [
            screen.table(rows),
            "worst decile: nine fingers in ten do as well or better",
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

    def _reach_lines(self, total: int) -> list[str]:
        reach = self.reach
        if reach is None:
            return ["which fingers can be given the set-point is not known: its levels are its own function's"]
        band = between(reach.low_n, reach.high_n)
        both, low, high, moving = (int(np.sum(each)) for each in (reach.able, ~reach.low, ~reach.high, reach.moving))
        drifts = f"that is at a steady load; as it drifts and trembles {moving} can, for 95 % of the time"
        return [
            f"able: {both} of {total} fingers can be given the set-point, {band},",
            f"for {reach.hold_s:g} s on the plate; {low} cannot get so low, {high} cannot get so high",
            *([drifts] if moving != both else []),
        ]

    def as_json(self) -> dict[str, Any]:
        """Return everything: each finger's metrics and reach, and what the summary says."""
        able, found = self._able(), super().as_json()
        del found["best"]
        names = [str(name) for name in self.result.data_vars]
        found["population"] = {name: self.spread(name) for name in names}
        found["lowest_n"], found["highest_n"] = self.result["lowest_n"].values, self.result["highest_n"].values
        found["asked_n"] = None if self.reach is None else [self.reach.low_n, self.reach.high_n]
        found["capable_load_moves"] = None if self.reach is None else self.reach.moving
        found["capable"], found["replaced"] = able, self._replaced[0]
        found["ringing"] = ringing.as_json(self.rings)
        if able is not None:
            found["population_capable"] = {name: self.spread(name, able) for name in names}
        return found


def _cell(value: float, units: str) -> str:
    return "-" if math.isnan(value) else shown(value, units)
