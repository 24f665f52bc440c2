"""What a person should know of a controller on a bench: where it rings, whom it does not serve, what is assumed."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from typing import Any

from frictionloop.analysis import command_noise_rms_n, linearise
from frictionloop.analysis.linear import condition_of
from frictionloop.analysis.operating_point import RECORDED, at_levels, force_band, law_at, missed, moistest, reach_at
from frictionloop.analysis.stability import NEAR, ringing_hz
from frictionloop.design.grid_corners import Corner, How, Place, corners
from frictionloop.design.hinf import COMMAND_NOISE_N
from frictionloop.design.operating_grid import Lean
from frictionloop.design.population_margins import MOST_PEAK, LoopGains
from frictionloop.design.requirements import Requirements
from frictionloop.findings import Condition, Finding
from frictionloop.parameters import FingerFriction, Strokes, SuspendedSensor, System, bench
from frictionloop.parameters.frozen_blocks import flat
from frictionloop.quantities import FrictionloopError

CODES: dict[How, str] = {"unstable": "LOOP-UNSTABLE", "near": "LOOP-NEAR", "beyond": "MS-BEYOND"}
OFF_BELIEF = 0.05
"""Share by which the friction at the mean load is off what a law believes, from which it is told (assumed)."""
MATTER = (
    *("friction.nominal_n", "friction.susceptibility_per_um2", "friction.occlusion_ratio", "friction.occlusion_s"),
    *("friction.moist_loss", "plate.max_amplitude_um", "sensor.cutoff_hz", "sensor.q", "controller.delay_s"),
    *("motion.load_n", "motion.lifted_s", "setpoint.offset_n", "setpoint.amplitude_n"),
)
"""Values that move the gains of a design and that a bench is often described without."""
LIGHTER, HEAVIER = 0.7, 1.4
"""Loads over that of the strokes between which a range is proposed: nobody presses evenly (assumed)."""


def of_places(places: Sequence[Place], count: int) -> Iterator[Finding]:
    """Yield where the limits do not hold, places alike in one; the first ``count`` places were asked for."""
    groups: dict[tuple[float | None, How, float, bool], list[Place]] = {}
    for k, each in enumerate(places):
        if each.how != "within":
            groups.setdefault((each.slip_length_um, each.how, each.worst.off, k < count), []).append(each)
    for (length, how, off, was_asked), group in groups.items():
        worst = max((each.worst for each in group), key=lambda corner: corner.excess)
        speeds = tuple(sorted({speed for each in group for speed in each.speeds_mm_s}))
        where = Condition(slip_length_um=length, speed_mm_s=speeds or None, resonance_off=off or None)
        rings = how == "unstable"
        yield Finding(
            CODES[how],
            severity="error" if was_asked else None,
            value=ringing_hz([worst.loop]) if rings else worst.sensitivity_peak,
            unit="Hz" if rings else "",
            limit=None if rings else worst.limit,
            where=where,
        )


def of_bench(system: System, found: Sequence[Corner], must: Requirements) -> Iterator[Finding]:
    """Yield what is known of bench and law without a look at other people."""
    yield from out_of_reach(found)
    yield from fully_moist(system, must)
    yield from beyond_range(system, must)
    yield from unbelieved(system)
    yield from noisy(system)
    friction = system.friction
    if isinstance(friction, FingerFriction) and (friction.occlusion_ratio, friction.moist_loss) == (1.0, 0.0):
        yield Finding("FINGER-DRY")
    if system.controller.kind == "lookup":
        yield Finding("NO-LOOP")
    if isinstance(system.motion, Strokes) and not must.loads_n:
        load_n = system.motion.load_n
        yield Finding(
            "LOAD-ONE", value=load_n, unit="N", remedy=f"--loads {LIGHTER * load_n:.2g},{HEAVIER * load_n:.2g}"
        )


def out_of_reach(found: Sequence[Corner]) -> Iterator[Finding]:
    """Yield the forces asked for that no amplitude gives, by state of the finger; the nearest counts in their place."""
    states = sorted({each.loop.elements.occluded for each in found})
    systems = {condition_of(each.loop.system): each.loop.system for each in found}
    worst: dict[tuple[float, bool], Finding] = {}
    for where, there in systems.items():
        for each in missed(there, states):
            at, low = each.occluded, each.force_n < each.instead_n
            known = worst.get((at, low))
            if known is None or each.short_n > abs(known.value - known.limit):
                pressed = Condition(load_n=where.load_n, occluded=at)
                worst[at, low] = Finding(
                    "FORCE-REACH", value=each.force_n, unit="N", limit=each.instead_n, where=pressed
                )
    yield from worst.values()


def fully_moist(system: System, must: Requirements) -> Iterator[Finding]:
    """Yield how the loop is on a finger that never lifts, once it is fully moist, if that is beyond its limits."""
    friction, motion = system.friction, system.motion
    if not (isinstance(friction, FingerFriction) and isinstance(motion, Strokes)) or motion.contact_s > 0:
        return
    grid = must.grid(3, 3)._replace(lean=Lean())
    there = grid.systems(system)
    beyond = [each for place in there for each in missed(place, [1.0])]
    if len(beyond) == sum(len(set(force_band(place))) for place in there):
        nearest = min(beyond, key=lambda each: each.short_n)
        where = Condition(occluded=1.0)
        yield Finding("FORCE-REACH", value=nearest.force_n, unit="N", limit=nearest.instead_n, where=where)
        return
    try:
        found = corners(system, grid, (1.0,))
    except FrictionloopError as error:
        yield Finding("PLACE-UNSEEN", where=Condition(occluded=1.0), more={"reason": str(error)})
        return
    worst = Place.of(found).worst
    if worst.excess > 1.0:
        near = worst.sensitivity_peak > NEAR
        yield Finding(
            "RING-MOIST",
            severity="warning" if near else "note",
            value=worst.sensitivity_peak,
            limit=worst.limit,
            where=replace(worst.condition, occluded=None, force_n=None, load_n=None),
            remedy={"motion.contact_s": 10.0},
        )


def beyond_range(system: System, must: Requirements) -> Iterator[Finding]:
    """Yield that friction without vibration exceeds the range of the sensor, on the moistest finger pressed hardest."""
    friction, motion, sensor = system.friction, system.motion, system.sensor
    if not isinstance(sensor, SuspendedSensor):
        return
    load_n, state, there = None, None, system
    if isinstance(motion, Strokes):
        load_n = max(must.loads_n, default=motion.load_n)
        there = system.evolve({"motion.load_n": load_n})
    if isinstance(friction, FingerFriction):
        state = moistest(friction, motion) if isinstance(motion, Strokes) and motion.contact_s > 0 else 1.0
    top_n = reach_at(there, state or 0.0).high_n
    if top_n > sensor.range_n:
        where = Condition(load_n=load_n, occluded=state)
        yield Finding("SENSOR-RANGE", value=top_n, unit="N", limit=sensor.range_n, where=where)


def unbelieved(system: System) -> Iterator[Finding]:
    """Yield that a law believes the friction at the reference load, of a finger with another."""
    friction, motion, model = system.friction, system.motion, system.controller.model
    if not (isinstance(friction, FingerFriction) and isinstance(motion, Strokes)):
        return
    there_n = law_at(system.evolve({"motion.speed_mm_s": friction.reference_speed_mm_s})).nominal_n
    if model.nominal_n == friction.nominal_n and abs(there_n / friction.nominal_n - 1.0) >= OFF_BELIEF:
        told = {"controller.model.nominal_n": float(f"{there_n:.3g}")}
        where = Condition(load_n=motion.load_n)
        yield Finding("BELIEF-FRICTION", value=there_n, unit="N", limit=model.nominal_n, where=where, remedy=told)


def noisy(system: System) -> Iterator[Finding]:
    """Yield that the sensor's noise makes more of the command than a synthesis may."""
    command_n = command_noise_rms_n(linearise(system))
    if command_n > COMMAND_NOISE_N:
        yield Finding("NOISE-COMMAND", value=1e3 * command_n, unit="mN", limit=1e3 * COMMAND_NOISE_N)


def of_people(people: LoopGains | None, law: str, looked_at: bool, gain: float | None) -> Iterator[Finding]:
    """Yield on how many people a loop comes close to ringing, and that none were looked at one by one.

    Nothing where a finger was measured, whose loop ``gain`` over the believed one it bears.
    """
    if people is None or (gain is not None and gain <= people.critical):
        return
    if math.isfinite(people.critical):  # else no gain makes it ring
        remedy = "--law limit_observer" if people.many and law != "limit_observer" else ""
        more = {"people": people.people, "loop_gain": people.critical, "sensitivity_peak": MOST_PEAK}
        severity: Any = "warning" if people.many else "note"
        yield Finding("PEOPLE-RING", severity, 100.0 * people.share, "%", remedy=remedy, more=more)
    if not looked_at:
        yield Finding("PEOPLE-NONE", remedy="--fingers 100")


def of_signals(system: System) -> Iterator[Finding]:
    """Yield what of a recorded signal counts where a controller is designed or checked."""
    levels = at_levels(system)
    for name in ("setpoint", "disturbance"):
        if getattr(system, name).kind in RECORDED:
            level: Any = getattr(levels, name)
            ends = {"offset": level.offset_n, "amplitude": getattr(level, "amplitude_n", 0.0)}
            yield Finding("RECORDED-LEVEL", value=level.offset_n, unit="N", where=Condition(recording=name), more=ends)


def of_assumed(system: System, given: Collection[str]) -> Iterator[Finding]:
    """Yield which numbers that move the gains are as in `bench()` and nobody gave."""
    own, usual = flat(system.model_dump()), flat(bench().model_dump())
    lifts = getattr(system.motion, "contact_s", 0.0) > 0.0
    same = [path for path in MATTER if path in own and own[path] == usual.get(path) and path not in given]
    named = {path: own[path] for path in same if lifts or path != "motion.lifted_s"}
    if named:
        yield Finding("ASSUMED", value=len(named), more={"values": named})
