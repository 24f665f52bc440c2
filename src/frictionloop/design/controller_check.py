"""Does a controller that is there hold? The corners, slip lengths and speeds of a design, and what gains would hold."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from itertools import chain
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.analysis.limits import headroom
from frictionloop.analysis.operating_point import at_levels
from frictionloop.control.limit_observer import MOST_MARGIN
from frictionloop.design import controller_findings
from frictionloop.design.controller_synthesis import check_places
from frictionloop.design.grid_corners import Place, at_mean, corners, elsewhere, worst_margins
from frictionloop.design.operating_grid import OperatingGrid, with_longest_contact
from frictionloop.design.plant_set import least_gain
from frictionloop.design.population_margins import (
    FingersInterrupted,
    LoopGains,
    check_fingers,
    loop_gains,
    of_fingers,
    scaled_gains,
    unlike,
)
from frictionloop.design.requirements import CHECKED, COARSE, Requirements
from frictionloop.design.tracking import Tracking, tracking
from frictionloop.findings import Finding, Result, shown
from frictionloop.findings.result import Figure, Row, Table, Tables, frame, plain
from frictionloop.findings.shown import between
from frictionloop.loop.progress import step
from frictionloop.loop.run_findings import error_table
from frictionloop.loop.run_ringing import of_loop, of_own_law
from frictionloop.parameters import System
from frictionloop.parameters.summary import gains_said
from frictionloop.perception.detection_thresholds import LOWEST_HZ
from frictionloop.quantities import FrictionloopError

HIGHER = 1.005
"""Factor on the gain below which no room is told: it would be read as 1."""


class Check(Result, schema="design.check/1"):
    """How a controller does on a bench."""

    system: System
    requirements: Requirements
    holds: bool
    """At all slip lengths, speeds and loads asked for, on this finger and on all others that were looked at."""
    places: tuple[Place, ...]
    """Slip lengths and speeds, those asked for first."""
    asked: int
    """How many of the places were asked for."""
    gain_factors: tuple[float, ...]
    """Factor on the loop gain up to which, with every smaller one, the limits hold, for each place."""
    would_hold: Mapping[str, float]
    """Overrides with which they hold at all places and on all fingers; empty where they do, or none were found."""
    people: LoopGains | None = None
    """On how many other people it comes close to ringing; None without a finger."""
    fingers: xr.Dataset | None = None
    """Other fingers one by one, as `check_fingers` has them."""
    drawn: Mapping[str, Any] = field(default_factory=dict)
    """What `fingers` was given for them."""
    tracking: Tracking | None = None
    """How well the set-point of the file is followed; None where that cannot be simulated."""

    @property
    def law(self) -> str:
        """Kind of the controller."""
        return self.system.controller.kind

    @property
    def holds_everywhere(self) -> bool:
        """Whether the limits hold at the places that were not asked for too."""
        return self.holds and all(place.how == "within" for place in self.places)

    def rows(self) -> list[Row]:
        """Return the law and its gains, the verdict, the error, and what would hold."""
        verdict = ("HOLDS", self.grid) if self.holds else ("DOES NOT HOLD", f"{self._beyond_on()}; {self.grid}")
        return [(self.law, gains_said(self.system)), verdict, *self._left(), *self._room()]

    def _left(self) -> Iterator[Row]:
        if (found := self.tracking) is not None:
            felt = f"; {shown(found.relative_index)} x a plain stroke to touch" * math.isfinite(found.relative_index)
            opened = shown(1e3 * found.open_loop_rms_error_n)
            yield "leaves", f"{shown(1e3 * found.rms_error_n)} mN rms of {opened} in open loop{felt}"

    def _beyond_on(self) -> str:
        """Return on how many of what was looked at it does not, the first of places, a run and people that fails."""
        beyond = sum(place.how != "within" for place in self.places)
        if any(place.how != "within" for place in self.places[: self.asked]):
            return f"at {beyond} of {len(self.places)} slip lengths and speeds"
        if self.contradicted or self.fingers is None:
            return "in a simulated run"
        seen = self.fingers["unseen"].values == ""
        return f"on {int((~self.fingers['holds'].values[seen]).sum())} of {int(seen.sum())} fingers"

    @property
    def contradicted(self) -> bool:
        """Whether a simulated run says otherwise than the margins of a law from outside."""
        return any(each.code == "LAW-CONTRADICTS" for each in self.findings)

    @property
    def looked_at(self) -> dict[str, tuple[float, float]]:
        """Least and largest of where it was looked at, by name: speed, slip length, force, force over load, load."""
        places = self.places[: self.asked]
        found = [corner for place in places for corner in place.corners]
        forces = [each.loop.elements.force_n for each in found]
        loads = [getattr(each.loop.system.motion, "load_n", None) for each in found]
        values: dict[str, list[float | None]] = {
            "speed_mm_s": [speed for place in places for speed in place.speeds_mm_s],
            "slip_length_um": [place.slip_length_um for place in places],
            "force_n": [*forces],
            "force_over_load": [f / load if load else None for f, load in zip(forces, loads, strict=True)],
            "load_n": [*loads],
            "occluded": [each.loop.elements.occluded for each in found],
            "resonance_off": [abs(each.off) for each in found],
        }
        there = {name: [each for each in some if each is not None] for name, some in values.items()}
        return {name: (min(some), max(some)) for name, some in there.items() if some}

    @property
    def grid(self) -> str:
        """Where it was looked at, in words."""
        found = self.looked_at
        names = (("speed_mm_s", "mm/s", ""), ("slip_length_um", "um", "slip "), ("force_n", "N", ""))
        said = [f"{head}{between(*found[name], unit)}" for name, unit, head in names if name in found]
        if "load_n" in found:
            said[-1] += f" ({between(*found['force_over_load'])} x load)"
            low, high = found["load_n"]
            said += [f"load {between(low, high, 'N')}"] * (low < high)
        moist, off = (100 * found[name][1] for name in ("occluded", "resonance_off"))
        said += [f"moist to {moist:.2g} %"] * (moist > 0) + [f"resonance ±{off:.3g} %"] * (off > 0)
        return ", ".join(said)

    @cached_property
    def would_leave(self) -> float | None:
        """Share of a disturbance at 1 Hz that the gains that would hold leave; None without such gains."""
        if not self.would_hold:
            return None
        loop = at_mean(at_levels(self.system).evolve(dict(self.would_hold)))
        return float(abs(loop.responses(LOWEST_HZ)["S"][0]))

    def _room(self) -> Iterator[Row]:
        gain = min(self.gain_factors)
        if self.contradicted:
            return
        if (left := self.would_leave) is not None:
            yield (
                "everywhere" if self.holds else "would hold",
                f"{shown(self.would_hold)}, leaving {left:.0%} of a disturbance at {LOWEST_HZ:g} Hz",
            )
        elif HIGHER <= gain < math.inf:
            yield "room", f"{shown(gain)} x the gain of the loop"

    def tables(self) -> Tables:
        """Return Ms over places and resonances, the least margins, and the error by reach."""
        error = {} if self.tracking is None else {"error": error_table(self.tracking.parts)}
        return {"Ms": self._peaks(), "least margins": self.margins(), **error}

    def plot(self) -> Figure:
        """Return a figure: the sensitivity of the loop, and of the worst corner, beside the least."""
        from frictionloop.design.response_figures import figure_sensitivity

        there, limits = at_levels(self.system), self.requirements.limits
        found = [corner for place in self.places[: self.asked] for corner in place.corners]
        worst = max(found, key=lambda each: each.sensitivity_peak)
        return figure_sensitivity(there, headroom(there, self.requirements.sensitivity_peak), limits, worst)

    def _peaks(self) -> Table:
        offs = sorted({corner.off for place in self.places for corner in place.corners})
        limits = {round(error, 9): peak for error, peak in self.requirements.limits.items()}
        rows = {"asked": [limits[round(abs(off), 9)] for off in offs] + [math.nan]}
        for place, gain in zip(self.places, self.gain_factors, strict=True):
            rows[str(place.condition) or "this loop"] = [*(place.peak_at(off) for off in offs), gain]
        heads = [f"{100 * off:+.3g} %" if off else "told" for off in offs]
        return frame(rows, "resonance", [*heads, "x gain"])

    def margins(self) -> Table:
        """Return the least margins where it was asked for, by resonance and moisture; they take a moment."""
        found = [corner for place in self.places[: self.asked] for corner in place.corners]
        rows = []
        for (off, occluded), group in sorted(worst_margins(found).items()):
            rows.append(
                {
                    "resonance off, %": 100 * off,
                    "moist, %": 100 * occluded,
                    "Ms": max(each.sensitivity_peak for each in group),
                    "gain": min((each.gain_margin for each in group), key=lambda factor: abs(math.log(factor))),
                    "phase, deg": min((each.phase_margin_deg for each in group), key=abs),
                    "delay, ms": 1e3 * min(each.delay_margin_s for each in group),
                }
            )
        return frame(rows, "resonance off, %")

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name, the least margins and the error of a run too."""
        more = {
            "margins": self.margins().reset_index().to_dict("records"),
            "limits": self.requirements.limits, "room": min(self.gain_factors), "would_leave": self.would_leave,
            "looked_at": self.looked_at,
        }  # fmt: skip
        return super().to_dict() | {"law": self.law} | plain(more)


def check(
    system: System,
    requirements: Requirements | None = None,
    people: Sequence[Mapping[str, Any]] | None = None,
    *,
    given: Collection[str] = (),
) -> Check:
    """Return how the controller of a System does, without a search for another one.

    It is looked at as a new design is: at lowest, mean and highest force, on a dry and a moist finger, with the
    resonance off, at the slip lengths, speeds and loads that are asked for; then at half and four times the speed.
    A force out of reach counts as the nearest that can be had. Of a recorded signal its levels count. A law from
    outside is simulated too.

    Parameters
    ----------
    system
        The bench with its controller, of any law that has a linear analysis.
    requirements
        What must hold. None: `Requirements` as it is.
    people
        Overrides, one finger each, as of `fingers`, on which it must hold too.
    given
        Dotted names of values that somebody gave, of which none counts as assumed.

    Raises
    ------
    FrictionloopError
        No force asked for is in reach of a finger just landed, or the law has no linear analysis.
    """
    must = requirements or Requirements()
    there = with_longest_contact(at_levels(system), must.speeds_mm_s)
    check_places(there, must)
    close = must.grid(*CHECKED)._replace(slip_lengths_um=())
    touched = OperatingGrid(must.slip_lengths_um).systems(there)
    own = [Place.of(corners(each, close)) for each in touched]
    return judged(system, there, own, must, people, given)


def judged(
    system: System,
    there: System,
    own: Sequence[Place],
    must: Requirements,
    people: Sequence[Mapping[str, Any]] | None,
    given: Collection[str],
) -> Check:
    """Return the check of a System whose margins at the places asked for are known; ``there`` it has levels."""
    grid = must.grid(*COARSE)
    more, unseen = elsewhere(there, grid, must.slip_lengths_um)
    places = (*own, *more)
    factors = tuple(_least_gain(place) for place in places)
    within, seen = all(place.how == "within" for place in places), loop_gains(there, grid)
    asked = all(place.how == "within" for place in own)
    fingers, stopped = _on_fingers(there, people, must)
    found = [corner for place in own for corner in place.corners]
    own_law = list(of_own_law(system, at_mean(there).elements.force_n)) if within else []
    followed = _tracking(system, must)
    told = chain(
        unlike(system, people) if people is not None else (),
        own_law,
        of_loop(followed.rms_error_n, followed.open_loop_rms_error_n) if asked and followed is not None else (),
        controller_findings.of_places(places, len(own)),
        of_fingers(fingers, lambda factor: scaled_gains(there, factor)) if fingers is not None else (),
        stopped,
        controller_findings.of_bench(there, found, must),
        controller_findings.of_people(seen, there.controller.kind, fingers is not None, must.finger_gain),
        controller_findings.of_signals(system),
        controller_findings.of_assumed(system, {*given, *(("motion.load_n",) if must.loads_n else ())}),
        unseen,
    )
    everyone = fingers is None or bool((fingers["holds"] | (fingers["unseen"] != "")).all())
    least = min(*factors, math.inf if fingers is None else float(np.nanmin(fingers["gain_factor"].values)))
    return Check(
        system=system,
        requirements=must,
        holds=asked and everyone and not own_law,
        places=places,
        asked=len(own),
        gain_factors=factors,
        would_hold={} if within and everyone else _would_hold(there, least),
        people=seen,
        fingers=fingers,
        drawn=getattr(people, "drawn", {}),
        tracking=followed,
        findings=tuple(told),
    )


def _tracking(system: System, must: Requirements) -> Tracking | None:
    try:
        return tracking(system, must.speeds_mm_s)
    except FrictionloopError:  # of a motion without a plateau, say
        return None


def _on_fingers(
    system: System, people: Sequence[Mapping[str, Any]] | None, must: Requirements
) -> tuple[xr.Dataset | None, tuple[Finding, ...]]:
    """Return what is found on other fingers; after Ctrl-C on those that were looked at, and that they are fewer."""
    if people is None:
        return None, ()
    try:
        return check_fingers(system, people, must), ()
    except FingersInterrupted as stop:
        count = stop.partial.sizes["finger"]
        return stop.partial, (Finding("STOPPED", value=count, limit=len(people)),)


def _least_gain(place: Place) -> float:
    step(f"what gain would hold, {place.condition}")
    return least_gain([each.loop for each in place.corners], [each.limit for each in place.corners])


def _would_hold(system: System, gain: float) -> Mapping[str, float]:
    """Return gains, or a margin, with which all corners hold."""
    controller: Any = system.controller
    if controller.kind == "limit_observer" and gain > 0.0:  # the inverse of its margin scales its gain
        margin = controller.susceptibility_margin / gain
        return {"controller.susceptibility_margin": float(f"{1.002 * margin:.4g}")} if margin <= MOST_MARGIN else {}
    return scaled_gains(system, gain)
