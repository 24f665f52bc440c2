"""The tile of an effect: its program runs at the place that the controller knows of, and at the true place beside it.

`rendering/player` is the same in plain Python. Lanes of a tile share one program; each has its own state.
"""

from __future__ import annotations

import math
from typing import Any

from frictionloop.loop.kernel.access import doubles, load, store
from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.quantities.normals import BLOCK
from frictionloop.rendering.effect import TURNS_MM_S
from frictionloop.rendering.program import FAR_S, MOST_TRIGGERS, WIDTH, Do

_SEEN, _TRUE, _STACK = ROW["effect_seen"], ROW["effect_true"], ROW["effect_stack"][0]
_ON, _SINCE = _SEEN.triggers.on_0 - _SEEN.direction, _SEEN.triggers.since_0 - _SEEN.direction
"""Where the triggers stand in a state, in rows from its first."""
TABLE, WAVE, ADD, MULTIPLY, LARGER, MIX, DIRECTION, SPEED, TRIGGER, SCALED = (int(do) for do in Do)


def _lift_table(lifting: Lifting) -> Any:
    """Return ``table(p, at, first, along_mm)``: the table of the instruction at ``at``."""

    @lifting.compiled
    def table(p, at, first, along_mm):  # type: ignore[no-untyped-def]
        count, repeats = load(p, 0, 1, at + 2), load(p, 0, 1, at + 6) > 0.0
        u = (along_mm - load(p, 0, 1, at + 3)) * load(p, 0, 1, at + 4)
        turned = u - count * math.floor(u / count)
        u = turned if repeats else min(max(u, 0.0), count - 1.0)
        u = math.floor(u + 0.5) if load(p, 0, 1, at + 5) > 0.0 else u
        cell = min(int(u), int(count) - (1 if repeats else 2))
        here, after = load(p, 0, 1, (first + cell, first + cell + 1))
        return here + (u - cell) * (after - here)

    return table


def _lift_wave(lifting: Lifting) -> Any:
    """Return ``wave(s, i, p, at, first, base, time_s)``: the wave of an instruction, since the start or its trigger."""
    width = lifting.width

    @lifting.compiled
    def wave(s, i, p, at, first, base, time_s):  # type: ignore[no-untyped-def]
        count, loops, trigger = load(p, 0, 1, at + 2), load(p, 0, 1, at + 4) > 0.0, int(load(p, 0, 1, at + 5))
        if trigger >= 0:
            time_s = load(s, i, width, base + _SINCE + trigger)
            if load(s, i, width, base + _ON + trigger) != load(p, 0, 1, at + 6) or time_s >= FAR_S:
                return 0.0
        u = time_s * load(p, 0, 1, at + 3)
        if loops:
            u -= count * math.floor(u / count)
        elif u > count - 1.0:
            return 0.0
        cell = min(int(u), int(count) - (1 if loops else 2))
        here, after = load(p, 0, 1, (first + cell, first + cell + 1))
        return here + (u - cell) * (after - here)

    return wave


def _lift_trigger(lifting: Lifting) -> Any:
    """Return ``trigger(s, i, p, at, base, quantity, begins)``: 1 if it is on, else 0, after it has changed or not."""
    width = lifting.width

    @lifting.compiled
    def trigger(s, i, p, at, base, quantity, begins):  # type: ignore[no-untyped-def]
        number = int(load(p, 0, 1, at + 1))
        on, off, dead = load(p, 0, 1, (at + 3, at + 4, at + 5))
        was_on, since = load(s, i, width, (base + _ON + number, base + _SINCE + number))
        now_on = quantity >= on if on > off else quantity <= on
        now_off = quantity <= off if on > off else quantity >= off
        if begins:
            was_on = 1.0 if now_on else 0.0
        elif since >= dead and (now_off if was_on > 0.0 else now_on):
            was_on, since = 1.0 - was_on, 0.0
        store(s, i, width, (base + _ON + number, base + _SINCE + number), (was_on, since))
        return was_on

    return trigger


def _lift_run(lifting: Lifting) -> Any:
    """Return ``run(s, i, p, base, along_mm, speed_mm_s, load_n, time_s, begins)``: all instructions, for one lane."""
    width, table = lifting.width, _lift_table(lifting)
    wave, trigger = _lift_wave(lifting), _lift_trigger(lifting)

    @lifting.compiled
    def run(s, i, p, base, along_mm, speed_mm_s, load_n, time_s, begins):  # type: ignore[no-untyped-def]
        count = int(load(p, 0, 1, 0))
        tables, top = 1 + count * WIDTH, _STACK
        for j in range(count):
            at = 1 + j * WIDTH
            do, first = int(load(p, 0, 1, at)), tables + int(load(p, 0, 1, at + 1))
            value = 0.0
            if do == TABLE:
                value = table(p, at, first, along_mm)
            elif do == WAVE:
                value = wave(s, i, p, at, first, base, time_s)
            elif do == TRIGGER:
                which = load(p, 0, 1, at + 2)
                quantity = load_n if which == 0.0 else abs(speed_mm_s) if which == 1.0 else along_mm
                value = trigger(s, i, p, at, base, quantity, begins)
            elif do == DIRECTION:
                value = load(s, i, width, base)
            elif do == SPEED:
                value = load(p, 0, 1, at + 1) * abs(speed_mm_s)
            elif do == SCALED:
                top -= 1
                value = load(p, 0, 1, at + 1) * load(s, i, width, top)
            elif do == MIX:
                top -= 3
                share, one, other = load(s, i, width, (top, top + 1, top + 2))
                value = other + min(max(share, 0.0), 1.0) * (one - other)
            else:
                top -= 2
                a, b = load(s, i, width, (top, top + 1))
                value = a + b if do == ADD else a * b if do == MULTIPLY else max(a, b)
            store(s, i, width, top, value)
            top += 1
        return load(s, i, width, _STACK)

    return run


def _lift_play(lifting: Lifting, plain: bool) -> Any:
    """Return ``play(s, i, p, base, along_m, speed_m_s, load_n, touches_n, k, dt)``: one period of one lane.

    A ``plain`` program is one table, and needs no stack.
    """
    width, compiled = lifting.width, lifting.compiled
    table, run, clamp = _lift_table(lifting), _lift_run(lifting), ROW["believed_clamp"]

    @compiled
    def play(s, i, p, base, along_m, speed_m_s, load_n, touches_n, k, dt):  # type: ignore[no-untyped-def]
        speed_mm_s = 1e3 * speed_m_s
        if abs(speed_mm_s) > TURNS_MM_S or k == 0:
            store(s, i, width, base, -1.0 if speed_mm_s < -TURNS_MM_S else 1.0)
        if load_n >= touches_n or k == 0:
            if plain:
                raw = table(p, 1, 1 + WIDTH, 1e3 * along_m)
            else:
                raw = run(s, i, p, base, 1e3 * along_m, speed_mm_s, load_n, k * dt, k == 0)
            low, high = load(s, i, width, clamp)
            store(s, i, width, base + 1, min(max(raw, low), high))
        if not plain:
            for j in range(MOST_TRIGGERS):
                store(s, i, width, base + _SINCE + j, load(s, i, width, base + _SINCE + j) + dt)
        return load(s, i, width, base + 1)

    return play


def build_effect(lifting: Lifting, plain: bool) -> Any:
    """Return the tile that sets the set-point of a period, and what the effect asks for at the true place."""
    width, compiled, count = lifting
    play = _lift_play(lifting, plain)
    told, touch = ROW["measurement"], ROW["touch_coefficients"].touch_n
    seen, true = _SEEN.direction, _TRUE.direction
    predicted = ROW["effect_lead"], ROW["touch"].position, ROW["touch"].speed
    moving, setpoint, intended = ROW["motion"][:3], ROW["setpoint"], ROW["intended"]

    @compiled
    def effect(s, n, k, at, o):  # type: ignore[no-untyped-def]
        p, out = doubles(o.effect), doubles(o.setpoint)
        for i in range(count(n)):
            lead, tracked, rate = load(s, i, width, predicted)
            _, position, speed, pressed, _ = load(s, i, width, told)
            along = tracked + lead * rate if lead >= 0.0 else position
            asked = play(s, i, p, seen, along, speed, pressed, load(s, i, width, touch), k, o.dt)
            store(s, i, width, setpoint, asked)
            if o.trace_size > 0:  # what is asked for at the true place is a trace alone
                x, v, load_n = load(s, i, width, moving)
                store(s, i, width, intended, play(s, i, p, true, x, v, load_n, 1e-12, k, o.dt))
            # An oracle takes the set-point from its buffer; what is asked for next is not known, and taken to be this.
            store(out, i, width, at, asked)
            store(out, i, width, min(at + 1, BLOCK - 1), asked)

    return effect
