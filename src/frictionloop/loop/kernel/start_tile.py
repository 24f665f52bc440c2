"""The tiles that put a finger and its sensor into their state at t = 0, and that tell f_a and what is reachable."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import load, peek, poke
from frictionloop.loop.kernel.motion_tile import DIRECTION, FACTOR, OCCLUDED, SPEED
from frictionloop.loop.kernel.slab import ROW, rows, vibration_rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.physics.contact import ContactCoefficients, ContactState
from frictionloop.physics.contact_bristle import lugre_force_step
from frictionloop.physics.friction_limit import static_step
from frictionloop.physics.motion import StrokePlan
from frictionloop.physics.vibration import Vibration
from frictionloop.quantities.arithmetic import fma


def lift_settle(lifting: Lifting, law: str) -> Any:
    """Return what puts finger and sensor where they had time enough to be before t = 0.

    A finger slides at t = 0 if it goes at half the speed of its stroke or more; one at rest only trembles.
    """
    width, compiled, count = lifting
    now, contact, force, stiff = ROW["motion"], ROW["contact"], ROW["contact_force"], law == "rigid"
    limit_row, per_bristle, compliance = ROW["limit_n"], ROW["contact_coefficients"] + 7, ROW["compliance"]
    springs, disturbance = ROW["suspension"], ROW["disturbance"]
    full_speed = ROW["stroke_plan"] + StrokePlan._fields.index("speed_m_s")

    @compiled
    def settle(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            speed = peek(s, (now + SPEED) * width + i)
            limit = peek(s, limit_row * width + i) * peek(s, (now + FACTOR) * width + i)
            slides = 0.5 * peek(s, full_speed * width + i)
            f = limit if speed >= slides else (-limit if speed <= -slides else 0.0)
            f = (limit if speed >= 0.0 else -limit) if stiff else f
            poke(s, force * width + i, f)
            poke(s, contact * width + i, f * peek(s, compliance * width + i))
            poke(s, (contact + 2) * width + i, f * peek(s, per_bristle * width + i))
            poke(s, (contact + 3) * width + i, limit * peek(s, per_bristle * width + i))
            pushed = fma(peek(s, (now + DIRECTION) * width + i), peek(s, disturbance * width + i), f)
            poke(s, springs * width + i, pushed)
            poke(s, (springs + 2) * width + i, pushed)

    return settle


def lift_tell(lifting: Lifting, law: str, vibration: Vibration) -> Any:
    """Return what tells f_a and what is reachable at t_k."""
    width, compiled, count = lifting
    now, contact, force = ROW["motion"], ROW["contact"], ROW["contact_force"]
    limit_row, friction_row, amplitude = ROW["limit_n"], ROW["friction"], ROW["amplitude"]
    floor, nominal, ceiling = ROW["floor"], ROW["nominal"], ROW["max_amplitude"]
    static_rows, remaining, effect_rows = rows("static"), vibration.step, vibration_rows(vibration)
    contact_rows, vibrated = ContactState(*rows("contact")), ROW["vibrated_limit"]
    given_rows = ContactCoefficients(*rows("contact_coefficients"))

    @compiled
    def limits(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            top = peek(s, limit_row * width + i) * peek(s, (now + FACTOR) * width + i)
            occluded, effect = peek(s, (now + OCCLUDED) * width + i), load(s, i, width, effect_rows)
            poke(s, nominal * width + i, top)
            poke(s, floor * width + i, top * remaining(peek(s, ceiling * width + i), occluded, effect))
            slip = peek(s, (now + SPEED) * width + i) - peek(s, contact_rows[1] * width + i)
            gain, per_speed = load(s, i, width, static_rows)
            left = remaining(peek(s, amplitude * width + i), occluded, effect)
            poke(s, vibrated * width + i, top * left * static_step(slip, gain, per_speed))

    @compiled
    def rigid(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            limit = peek(s, vibrated * width + i)
            forward = peek(s, (now + SPEED) * width + i) >= 0.0
            poke(s, force * width + i, limit if forward else -limit)

    @compiled
    def lugre(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            state, given = load(s, i, width, contact_rows), load(s, i, width, given_rows)
            speed = peek(s, (now + SPEED) * width + i)
            poke(s, force * width + i, lugre_force_step(state, peek(s, vibrated * width + i), speed, given))

    @compiled
    def bristle(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            z = peek(s, (contact + 2) * width + i)
            poke(s, force * width + i, peek(s, given_rows[6] * width + i) * z)

    @compiled
    def slider(s, n):  # type: ignore[no-untyped-def]
        bristle(s, n)
        # Under a falling limit its bristle has slid with that of the middle of the substep.
        for i in range(count(n)):
            f, limit = peek(s, force * width + i), peek(s, vibrated * width + i)
            poke(s, force * width + i, min(max(f, -limit), limit))

    of_contact = {"rigid": rigid, "dahl": bristle, "lugre": lugre, "slider": slider}[law]

    @compiled
    def tell(s, n):  # type: ignore[no-untyped-def]
        limits(s, n)
        of_contact(s, n)
        for i in range(count(n)):
            poke(s, friction_row * width + i, peek(s, (now + DIRECTION) * width + i) * peek(s, force * width + i))

    return tell
