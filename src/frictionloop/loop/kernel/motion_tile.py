"""The parts of tiles that move a finger on from one control period to the next, and measure its motion."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import peek, poke
from frictionloop.loop.kernel.lift import lift
from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.physics.finger_step import Motion, factor_step, landed_step, move_step, scored_step
from frictionloop.physics.friction_limit import LimitCoefficients, OcclusionCoefficients
from frictionloop.physics.motion import LoadPlan, StrokePlan
from frictionloop.physics.roughness import roughness_between, roughness_cells
from frictionloop.physics.tremor import TremorCoefficients, TremorState, tremor_step
from frictionloop.quantities.arithmetic import fma, step
from frictionloop.sensing.touch import DEVELOPED_M, TouchCoefficients, TouchState, touch_step

NOW, NEXT = Motion(*rows("motion")), Motion(*rows("motion_next"))
"""Rows of the finger at t_k and t_k+1."""
_ALONG, _ACROSS = TremorState(*rows("tremor")[:2]), TremorState(*rows("tremor")[2:])
_LIMIT = LimitCoefficients(*rows("limit_coefficients"))


@step
def same_step(value: Any) -> Any:
    """As it is."""
    return value


@step
def tracked_step(position: float, speed: float, load: float) -> tuple[float, float, float, float]:
    """The tracker of the position sensor has settled before t = 0."""
    return position, speed, load, DEVELOPED_M if load > 0.0 else 0.0


def lift_motion(lifting: Lifting) -> tuple[Any, Any, Any, Any]:
    """Return what takes over the motion of t_k, goes on to t_k+1, begins at t = 0, and accepts a given motion."""
    compiled = lifting.compiled
    keep = lift(lifting, same_step, (NEXT,), NOW)
    count_in = lift(lifting, scored_step, (NOW.place, NOW.load, *rows("unscored")), ROW["scored"])
    coefficients, draws = rows("tremor_coefficients"), rows("draws")
    along = lift(lifting, tremor_step, (_ALONG, draws[0], TremorCoefficients(*coefficients[:6])), _ALONG)
    across = lift(lifting, tremor_step, (_ACROSS, draws[1], TremorCoefficients(*coefficients[6:])), _ACROSS)
    plans = StrokePlan(*rows("stroke_plan")), LoadPlan(*rows("load_plan"))
    moved = NEXT.position, NEXT.speed, NEXT.load, NEXT.direction, NEXT.place
    move = lift(lifting, move_step, (*plans, _ALONG, _ACROSS), moved, extra=1)
    scan, rough = _lift_roughness(lifting), ROW["rough"]
    dried = OcclusionCoefficients(*rows("occlusion_coefficients"))
    under = NEXT.load, NEXT.speed, NOW.occluded, rough, dried, _LIMIT
    limit = lift(lifting, factor_step, under, (NEXT.occluded, NEXT.factor))
    land = lift(lifting, landed_step, (NEXT.load, NEXT.speed, rough, _LIMIT), (NEXT.occluded, NEXT.factor))
    track = lift(lifting, tracked_step, (NEXT.position, NEXT.speed, NEXT.load), rows("touch"))

    @compiled
    def take_over(s, n):  # type: ignore[no-untyped-def]
        keep(s, n)
        count_in(s, n)

    @compiled
    def go_on(s, n, t, table):  # type: ignore[no-untyped-def]
        along(s, n)
        across(s, n)
        move(s, n, t)
        scan(s, n, table)
        limit(s, n)

    @compiled
    def begin(s, n, table):  # type: ignore[no-untyped-def]
        move(s, n, 0.0)
        track(s, n)
        scan(s, n, table)
        land(s, n)

    @compiled
    def accept(s, n, table):  # type: ignore[no-untyped-def]
        scan(s, n, table)
        limit(s, n)

    return take_over, go_on, begin, accept


def _lift_roughness(lifting: Lifting) -> Any:
    """Return what looks roughness up: a gather, which does not vectorise, and so has a loop of its own."""
    width, compiled, count = lifting
    position, per_m, rough = NEXT.position, ROW["roughness_per_m"], ROW["rough"]

    @compiled
    def scan(s, n, table):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            cell, next_, fraction = roughness_cells(peek(s, position * width + i), peek(s, per_m * width + i))
            here, there = peek(table, cell * width + i), peek(table, next_ * width + i)
            poke(s, rough * width + i, roughness_between(fraction, here, there))

    return scan


@step
def follow_step(state, position, load, z_position, z_load, given, force):  # type: ignore[no-untyped-def]
    """Measured position, speed, load and validity, and the force along the measured motion."""
    state, seen = touch_step(state, position, load, z_position, z_load, given)
    return state, seen, fma(1.0 if seen[1] >= 0.0 else -1.0, force, 0.0)


def lift_touch(lifting: Lifting) -> Any:
    """Return what measures position, speed and load, and turns the force along the measured motion."""
    state, (force, *told) = TouchState(*rows("touch")), rows("measurement")
    given = state, NOW.position, NOW.load, *rows("draws")[2:], TouchCoefficients(*rows("touch_coefficients")), force
    return lift(lifting, follow_step, given, (state, tuple(told), force))
