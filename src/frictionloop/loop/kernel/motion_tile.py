"""The parts of tiles that move a finger on from one control period to the next, and measure its motion."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.step_lifting import Lifting, lift, lift_gather
from frictionloop.physics.finger_step import factor_step, landed_step, move_step, scored_step
from frictionloop.physics.roughness import roughness_between, roughness_cells
from frictionloop.physics.tremor import tremor_step
from frictionloop.quantities.scalar_math import step
from frictionloop.sensing.finger_tracking import touch_step

_NOW, _NEXT, _ROUGH, _LIMIT = ROW["motion"], ROW["motion_next"], ROW["rough"], ROW["limit_coefficients"]
_TREMOR, _PLANS = (ROW["tremor_along"], ROW["tremor_across"]), (ROW["stroke_plan"], ROW["load_plan"])


@step
def kept_step(motion, unscored):  # type: ignore[no-untyped-def]
    """The motion as it is, and whether a period with it counts."""
    return motion, scored_step(motion.place, motion.load, *unscored)


@step
def begin_step(tremor, plans, developed_m):  # type: ignore[no-untyped-def]
    """Motion at t = 0, before which skin and filter of the position sensor have settled (as `settled_of`)."""
    position, speed, load, direction, place = move_step(0.0, 1.0, *plans, *tremor)
    missing_m = 0.0 if (load > 0.0) & (abs(speed) >= 0.5 * plans[0].speed_m_s) else developed_m
    return (position, speed, load, direction, place), (position, speed, load, missing_m, 0.0, direction, abs(speed))


@step
def tremble_step(t, direction, tremor, draws, coefficients, plans):  # type: ignore[no-untyped-def]
    """Tremor and motion at time t."""
    along = tremor_step(tremor[0], draws[0], coefficients[0])
    across = tremor_step(tremor[1], draws[1], coefficients[1])
    return (along, across), move_step(t, direction, *plans, along, across)


@step
def follow_step(state, position, load, draws, given, force):  # type: ignore[no-untyped-def]
    """Measured position, speed, load and validity, and the force along the measured motion."""
    state, seen = touch_step(state, position, load, draws[2], draws[3], given)
    return state, seen, state.direction * force


def lift_motion(lifting: Lifting) -> tuple[Any, Any, Any, Any, Any]:
    """Return what takes over the motion of t_k, measures it, goes on to t_k+1, begins at t = 0, accepts a given one."""
    keep = lift(lifting, kept_step, (_NEXT, ROW["unscored"]), (_NOW, ROW["scored"]))
    touch, (force, *told) = ROW["touch"], ROW["measurement"]
    seen = touch, _NOW.position, _NOW.load, ROW["draws"], ROW["touch_coefficients"], force
    follow = lift(lifting, follow_step, seen, (touch, tuple(told), force))
    moved = _NEXT.position, _NEXT.speed, _NEXT.load, _NEXT.direction, _NEXT.place
    coefficients = ROW["tremor_along_coefficients"], ROW["tremor_across_coefficients"]
    tremble = lift(
        lifting, tremble_step, (_NOW.direction, _TREMOR, ROW["draws"], coefficients, _PLANS), (_TREMOR, moved)
    )
    start = lift(lifting, begin_step, (_TREMOR, _PLANS, ROW["touch_coefficients"].developed_m), (moved, touch))
    under = _NEXT.load, _NEXT.speed, _NOW.occluded, _ROUGH, ROW["occlusion_coefficients"], _LIMIT
    limit = lift(lifting, factor_step, under, (_NEXT.occluded, _NEXT.factor))
    land = lift(lifting, landed_step, (_NEXT.load, _NEXT.speed, _ROUGH, _LIMIT), (_NEXT.occluded, _NEXT.factor))
    cells = _NEXT.position, ROW["roughness_per_m"]
    scan = lift_gather(lifting, roughness_cells, roughness_between, cells, _ROUGH)

    @lifting.compiled
    def accept(s, n, table):  # type: ignore[no-untyped-def]
        scan(s, n, table)
        limit(s, n)

    @lifting.compiled
    def go_on(s, n, t, table):  # type: ignore[no-untyped-def]
        tremble(s, n, t)
        accept(s, n, table)

    @lifting.compiled
    def begin(s, n, table):  # type: ignore[no-untyped-def]
        start(s, n)
        scan(s, n, table)
        land(s, n)

    return keep, follow, go_on, begin, accept
