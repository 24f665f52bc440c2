"""From a bench to a controller that holds on it, and what it leaves."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from frictionloop.analysis.limits import headroom
from frictionloop.analysis.linear import condition_of
from frictionloop.analysis.operating_point import at_levels
from frictionloop.design.controller_check import Check, judged
from frictionloop.design.controller_synthesis import LEAST_KI, default_law, lowered, synthesised
from frictionloop.design.grid_corners import Corner, Place, corners
from frictionloop.design.operating_grid import with_longest_contact
from frictionloop.design.population_margins import check_fingers
from frictionloop.design.requirements import CHECKED, Designed, Requirements
from frictionloop.findings import Finding
from frictionloop.findings.result import Figure, Tables, frame
from frictionloop.firmware.board_compatibility import gain_findings
from frictionloop.parameters import System


class ControllerDesign(Check, schema="design.controller/1"):
    """A controller that was found for a bench, and how it does."""

    overrides: Mapping[str, Any]
    """The controller, for ``System.evolve`` on the bench."""
    bench: System
    """What it was designed for, with the controller that was there."""
    headroom: Mapping[str, Any]
    """Disturbance, residual and the least residual in N, and what limits the crossover, in Hz and degrees."""
    lowered_by: float = 1.0
    """Factor on the gains for which they hold on all of other fingers too."""

    def tables(self) -> Tables:
        """Return the tables of the check, and what is left to gain."""
        left = frame(self.headroom, "left to gain, mean force, just landed", ["value"])
        return super().tables() | {"left to gain": left}

    def plot(self, name: str = "sensitivity") -> Figure:
        """Return a figure: the sensitivity of the loop beside the least, or a ``step`` before and after."""
        from frictionloop.design.response_figures import figure_step, step_run, stepped

        if name != "step":
            return super().plot()
        after = at_levels(self.system)
        return figure_step(step_run(at_levels(self.bench)), step_run(after), stepped(after)[1])


def controller(
    system: System,
    law: str | None = None,
    requirements: Requirements | None = None,
    people: Sequence[Mapping[str, Any]] | None = None,
    *,
    given: Collection[str] = (),
) -> ControllerDesign:
    """Return a controller whose margins hold over forces, a dry and a moist finger, resonances and people.

    Parameters
    ----------
    system
        The bench; of its controller only times and model are used.
    law
        notch_pi, pi, limit_observer or hinf; None: notch_pi, or pi for a force sensor without a resonance.
    requirements
        What must hold. None: `Requirements` as it is. Where it names no slip length and no controller holds from 0
        on, the answer is for that of the system, with a finding.
    people
        Overrides, one finger each: PI gains are lowered until the limits hold on all of them.
    given
        Dotted names of values that somebody gave, of which none counts as assumed.

    Raises
    ------
    FrictionloopError
        An unknown law, no force asked for that is in reach of a finger just landed, or no controller of that law
        holds: the line says what limits it.
    """
    name, must = law or default_law(system), requirements or Requirements()
    levels = with_longest_contact(at_levels(system), must.speeds_mm_s)
    found, must = synthesised(levels, name, must)
    factor, more = 1.0, tuple[Finding, ...]()
    if people is not None:
        found, factor, more = _for_fingers(levels, found, people, must)
    after = levels.evolve(dict(found.overrides))
    own = {block: getattr(system, block) for block in ("setpoint", "disturbance", "motion")}
    new = after.evolve(own)
    checked = judged(new, after, places_of(found.corners), must, people, given)
    return ControllerDesign(
        **{each.name: getattr(checked, each.name) for each in fields(Check) if each.name != "findings"},
        findings=(*more, *checked.findings, *found.findings, *gain_findings(new)),
        overrides=found.overrides,
        bench=system,
        headroom=left_to_gain(after, must),
        lowered_by=factor,
    )


def places_of(found: Sequence[Corner]) -> list[Place]:
    """Return corners by slip length."""
    groups: dict[float | tuple[float, ...] | None, list[Corner]] = {}
    for each in found:
        groups.setdefault(condition_of(each.loop.system).slip_length_um, []).append(each)
    return [Place.of(group) for group in groups.values()]


def _for_fingers(
    system: System, found: Designed, people: Sequence[Mapping[str, Any]], must: Requirements
) -> tuple[Designed, float, tuple[Finding, ...]]:
    """Return a controller with PI gains that hold on all fingers that can be looked at, and the factor on its gains.

    Gains of another law stay, and so do those that would leave a ki with which nothing is lowered that is felt.
    """
    many = check_fingers(system.evolve(dict(found.overrides)), people, must)
    factor = float(np.nanmin(many["gain_factor"].values))
    if factor >= 1.0:
        return found, 1.0, ()
    lower = lowered(found, factor)
    ki = math.nan if lower is None else float(lower.overrides["controller.ki"])
    if lower is None or ki <= LEAST_KI:
        return found, 1.0, (Finding("NOT-LOWERED", value=ki, unit="1/s", limit=LEAST_KI),)
    at = corners(system.evolve(lower.overrides), must.grid(*CHECKED))
    held = int(many["holds"].sum())
    told = Finding("LOWERED", value=factor, more={"held": held, "fingers": many.sizes["finger"]})
    return lower._replace(corners=tuple(at), findings=found.findings), factor, (told,)


def left_to_gain(system: System, must: Requirements) -> dict[str, Any]:
    """Return what a loop leaves and must leave at the mean force on a dry finger, and what limits its crossover."""
    left = headroom(system, must.sensitivity_peak)
    lag = left.lag
    return {
        "disturbance_mn": 1e3 * left.disturbance_rms_n,
        "disturbance_felt_mn": 1e3 * left.disturbance_felt_rms_n,
        "residual_mn": 1e3 * left.residual_rms_n,
        "least_residual_mn": 1e3 * left.least_rms_n,
        "zero_db_hz": left.zero_db_hz,
        "least_zero_db_hz": left.least_zero_db_hz,
        "delay_limit_hz": left.delay_limit_hz,
        "plain_limit_hz": left.plain_limit_hz,
        "lag_springs_deg": lag.springs,
        "lag_plate_deg": lag.plate,
        "lag_electronics_deg": lag.electronics,
        "lag_delay_deg": lag.delay,
        "lag_hold_deg": lag.hold,
    }
