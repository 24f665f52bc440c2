"""The parts of tiles that move a finger on from one control period to the next, and measure its motion."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import peek, poke
from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.tiles import Lifting, chain, lift
from frictionloop.physics.finger_step import factor_step, landed_step, move_step, scored_step
from frictionloop.physics.roughness import roughness_between, roughness_cells
from frictionloop.physics.tremor import tremor_step
from frictionloop.quantities.arithmetic import fma, step
from frictionloop.sensing.touch import DEVELOPED_M, touch_step

_NOW, _NEXT, _ROUGH, _LIMIT = ROW["motion"], ROW["motion_next"], ROW["rough"], ROW["limit_coefficients"]


@step
def same_step(value: Any) -> Any:
    """As it is."""
    return value


@step
def tracked_step(position: float, speed: float, load: float) -> tuple[float, float, float, float]:
    """The tracker of the position sensor has settled before t = 0."""
    return position, speed, load, DEVELOPED_M if load > 0.0 else 0.0


@step
def follow_step(state, position, load, z_position, z_load, given, force):  # type: ignore[no-untyped-def]
    """Measured position, speed, load and validity, and the force along the measured motion."""
    state, seen = touch_step(state, position, load, z_position, z_load, given)
    return state, seen, fma(1.0 if seen[1] >= 0.0 else -1.0, force, 0.0)


def lift_motion(lifting: Lifting) -> tuple[Any, Any, Any, Any]:
    """Return what takes over the motion of t_k, goes on to t_k+1, begins at t = 0, and accepts a given motion."""
    keep = lift(lifting, same_step, (_NEXT,), _NOW)
    count_in = lift(lifting, scored_step, (_NOW.place, _NOW.load, *ROW["unscored"]), ROW["scored"])
    along, across, draws = ROW["tremor_along"], ROW["tremor_across"], ROW["draws"]
    tremble = chain(
        lifting,
        lift(lifting, tremor_step, (along, draws[0], ROW["tremor_along_coefficients"]), along),
        lift(lifting, tremor_step, (across, draws[1], ROW["tremor_across_coefficients"]), across),
    )
    moved = _NEXT.position, _NEXT.speed, _NEXT.load, _NEXT.direction, _NEXT.place
    move = lift(lifting, move_step, (ROW["stroke_plan"], ROW["load_plan"], along, across), moved)
    under = _NEXT.load, _NEXT.speed, _NOW.occluded, _ROUGH, ROW["occlusion_coefficients"], _LIMIT
    limit = lift(lifting, factor_step, under, (_NEXT.occluded, _NEXT.factor))
    land = lift(lifting, landed_step, (_NEXT.load, _NEXT.speed, _ROUGH, _LIMIT), (_NEXT.occluded, _NEXT.factor))
    track = lift(lifting, tracked_step, (_NEXT.position, _NEXT.speed, _NEXT.load), ROW["touch"])
    scan = _lift_roughness(lifting)

    @lifting.compiled
    def accept(s, n, table):  # type: ignore[no-untyped-def]
        scan(s, n, table)
        limit(s, n)

    @lifting.compiled
    def go_on(s, n, t, table):  # type: ignore[no-untyped-def]
        tremble(s, n)
        move(s, n, t)
        accept(s, n, table)

    @lifting.compiled
    def begin(s, n, table):  # type: ignore[no-untyped-def]
        move(s, n, 0.0)
        track(s, n)
        scan(s, n, table)
        land(s, n)

    return chain(lifting, keep, count_in), go_on, begin, accept


def _lift_roughness(lifting: Lifting) -> Any:
    """Return what looks roughness up: a gather, which does not vectorise, and so has a loop of its own."""
    width, compiled, count = lifting
    position, per_m = _NEXT.position, ROW["roughness_per_m"]

    @compiled
    def scan(s, n, table):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            cell, next_, fraction = roughness_cells(peek(s, position * width + i), peek(s, per_m * width + i))
            here, there = peek(table, cell * width + i), peek(table, next_ * width + i)
            poke(s, _ROUGH * width + i, roughness_between(fraction, here, there))

    return scan


def lift_touch(lifting: Lifting) -> Any:
    """Return what measures position, speed and load, and turns the force along the measured motion."""
    state, (force, *told) = ROW["touch"], ROW["measurement"]
    given = state, _NOW.position, _NOW.load, *ROW["draws"][2:], ROW["touch_coefficients"], force
    return lift(lifting, follow_step, given, (state, tuple(told), force))
