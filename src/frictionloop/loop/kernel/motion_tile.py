"""The tiles of the finger's motion: what it does from one control period to the next, and what is measured of it."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import load, peek, poke, store
from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.physics.friction_limit import LimitCoefficients, OcclusionCoefficients, limit_step, occlusion_step
from frictionloop.physics.motion import LoadPlan, StrokePlan, load_step, stroke_step
from frictionloop.physics.roughness import roughness_between, roughness_cells
from frictionloop.physics.tremor import TremorCoefficients, TremorState, tremor_step
from frictionloop.quantities.arithmetic import fma
from frictionloop.sensing.touch import DEVELOPED_M, TouchCoefficients, TouchState, touch_step

POSITION, SPEED, LOAD, FACTOR, OCCLUDED, DIRECTION, PLACE = range(7)
"""Rows of ``motion`` and ``motion_next``."""


def lift_motion(lifting: Lifting) -> tuple[Any, Any, Any, Any]:
    """Return the tiles that take over the motion of t_k, go on to t_k+1, begin at t = 0, and accept a given motion.

    The looked-up roughness is a gather, which does not vectorise, and has a loop of its own.
    """
    width, compiled, count = lifting
    now, after, rough = ROW["motion"], ROW["motion_next"], ROW["rough"]
    stroke_rows, load_rows, limit_rows = rows("stroke_plan"), rows("load_plan"), rows("limit_coefficients")
    occlusion_rows, draw_row, per_m = rows("occlusion_coefficients"), ROW["draws"], ROW["roughness_per_m"]
    tremor, tremor_rows = rows("tremor"), rows("tremor_coefficients")
    along, across = (tremor[:2], tremor_rows[:6]), (tremor[2:], tremor_rows[6:])
    scored, unscored, tracked = ROW["scored"], ROW["unscored"], ROW["touch"]

    @compiled
    def take_over(s, n):  # type: ignore[no-untyped-def]
        for row in range(7):
            for i in range(count(n)):
                poke(s, (now + row) * width + i, peek(s, (after + row) * width + i))
        for i in range(count(n)):
            inside = abs(peek(s, (now + PLACE) * width + i)) <= peek(s, unscored * width + i)
            pressed = peek(s, (now + LOAD) * width + i) >= peek(s, (unscored + 1) * width + i)
            poke(s, scored * width + i, 1.0 if inside & pressed else 0.0)

    @compiled
    def tremble(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            state, given = TremorState(*load(s, i, width, along[0])), TremorCoefficients(*load(s, i, width, along[1]))
            store(s, i, width, along[0], tremor_step(state, peek(s, draw_row * width + i), given))
            state, given = TremorState(*load(s, i, width, across[0])), TremorCoefficients(*load(s, i, width, across[1]))
            store(s, i, width, across[0], tremor_step(state, peek(s, (draw_row + 1) * width + i), given))

    @compiled
    def move(s, n, t):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            place, speed = stroke_step(t, StrokePlan(*load(s, i, width, stroke_rows)))
            shift, rate, push, _ = load(s, i, width, tremor)
            pressed = load_step(t, push, LoadPlan(*load(s, i, width, load_rows)))
            poke(s, (after + PLACE) * width + i, place)
            poke(s, (after + DIRECTION) * width + i, 1.0 if speed >= 0.0 else -1.0)
            poke(s, (after + POSITION) * width + i, place + shift)
            poke(s, (after + SPEED) * width + i, speed + rate)
            poke(s, (after + LOAD) * width + i, pressed)

    @compiled
    def scan(s, n, table):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            x, per = peek(s, (after + POSITION) * width + i), peek(s, per_m * width + i)
            cell, next_, fraction = roughness_cells(x, per)
            here, there = peek(table, cell * width + i), peek(table, next_ * width + i)
            poke(s, rough * width + i, roughness_between(fraction, here, there))

    @compiled
    def limit(s, n, begins):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            pressed, speed = peek(s, (after + LOAD) * width + i), peek(s, (after + SPEED) * width + i)
            given = OcclusionCoefficients(*load(s, i, width, occlusion_rows))
            occluded = occlusion_step(peek(s, (now + OCCLUDED) * width + i), pressed, given)
            occluded = 0.0 if begins else occluded
            law = LimitCoefficients(*load(s, i, width, limit_rows))
            poke(s, (after + OCCLUDED) * width + i, occluded)
            poke(s, (after + FACTOR) * width + i, limit_step(pressed, speed, occluded, peek(s, rough * width + i), law))

    @compiled
    def go_on(s, n, t, table):  # type: ignore[no-untyped-def]
        tremble(s, n)
        move(s, n, t)
        scan(s, n, table)
        limit(s, n, False)

    @compiled
    def begin(s, n, table):  # type: ignore[no-untyped-def]
        move(s, n, 0.0)
        # The tracker of the position sensor has settled, too.
        for i in range(count(n)):
            poke(s, tracked * width + i, peek(s, (after + POSITION) * width + i))
            pressed = peek(s, (after + LOAD) * width + i)
            poke(s, (tracked + 1) * width + i, peek(s, (after + SPEED) * width + i))
            poke(s, (tracked + 2) * width + i, pressed)
            poke(s, (tracked + 3) * width + i, DEVELOPED_M if pressed > 0.0 else 0.0)
        scan(s, n, table)
        limit(s, n, True)

    @compiled
    def accept(s, n, table):  # type: ignore[no-untyped-def]
        scan(s, n, table)
        limit(s, n, False)

    return take_over, go_on, begin, accept


def lift_touch(lifting: Lifting) -> Any:
    """Return the tile that measures position, speed and load, and turns the force along the measured motion."""
    width, compiled, count = lifting
    now, draw_row, force = ROW["motion"], ROW["draws"], ROW["measurement"]
    state_rows, given_rows, told = rows("touch"), rows("touch_coefficients"), rows("measurement")[1:]

    @compiled
    def follow(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            z_position, z_load = peek(s, (draw_row + 2) * width + i), peek(s, (draw_row + 3) * width + i)
            position, pressed = peek(s, (now + POSITION) * width + i), peek(s, (now + LOAD) * width + i)
            state, given = TouchState(*load(s, i, width, state_rows)), TouchCoefficients(*load(s, i, width, given_rows))
            state, seen = touch_step(state, position, pressed, z_position, z_load, given)
            store(s, i, width, state_rows, state)
            store(s, i, width, told, seen)
            forward = 1.0 if seen[1] >= 0.0 else -1.0
            poke(s, force * width + i, fma(forward, peek(s, force * width + i), 0.0))

    return follow
