"""The tiles that put a finger and its sensor into their state at t = 0, and that tell f_a and what is reachable."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.exchange import CONTACTS
from frictionloop.loop.kernel.motion_tile import DIRECTION, FACTOR, OCCLUDED, SPEED
from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.slab_access import load, peek, poke
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.physics.contact import ContactCoefficients, ContactState
from frictionloop.physics.contact_bristle import lugre_force_step
from frictionloop.physics.friction_limit import static_step, vibrated_step
from frictionloop.physics.motion import StrokePlan
from frictionloop.quantities.arithmetic import fma


def build_start(lifting: Lifting) -> tuple[Any, Any]:
    """Return ``settle``: finger and sensor before t = 0 have had time enough; and ``tell``: f_a and its band at t_k.

    A finger slides at t = 0 if it goes at half the speed of its stroke or more; one at rest only trembles.
    """
    width, compiled, count = lifting
    now, contact, force = ROW["motion"], ROW["contact"], ROW["contact_force"]
    limit_row, per_bristle, compliance = ROW["limit_n"], ROW["contact_coefficients"] + 7, ROW["compliance"]
    springs, disturbance, friction_row = ROW["suspension"], ROW["disturbance"], ROW["friction"]
    floor, nominal, ceiling = ROW["floor"], ROW["nominal"], ROW["max_amplitude"]
    per_halving, loss, amplitude = ROW["halving_amplitude"] + 1, ROW["moist_loss"], ROW["amplitude"]
    static_rows = rows("static")
    contact_rows, given_rows, vibrated = rows("contact"), rows("contact_coefficients"), ROW["vibrated_limit"]
    full_speed = ROW["stroke_plan"] + StrokePlan._fields.index("speed_m_s")
    rigid, lugre, slider = CONTACTS.index("rigid"), CONTACTS.index("lugre"), CONTACTS.index("slider")

    @compiled
    def settle(s, n, stiff):  # type: ignore[no-untyped-def]
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

    @compiled
    def tell(s, n, law):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            top = peek(s, limit_row * width + i) * peek(s, (now + FACTOR) * width + i)
            scale, occluded = peek(s, per_halving * width + i), peek(s, (now + OCCLUDED) * width + i)
            moist = peek(s, loss * width + i)
            poke(s, nominal * width + i, top)
            poke(s, floor * width + i, top * vibrated_step(peek(s, ceiling * width + i) * scale, occluded, moist))
            y = peek(s, amplitude * width + i) * scale
            slip = peek(s, (now + SPEED) * width + i) - peek(s, contact_rows[1] * width + i)
            gain, per_speed = load(s, i, width, static_rows)
            poke(s, vibrated * width + i, top * vibrated_step(y, occluded, moist) * static_step(slip, gain, per_speed))
        if law == rigid:
            for i in range(count(n)):
                limit = peek(s, vibrated * width + i)
                forward = peek(s, (now + SPEED) * width + i) >= 0.0
                poke(s, force * width + i, limit if forward else -limit)
        elif law == lugre:
            for i in range(count(n)):
                state = ContactState(*load(s, i, width, contact_rows))
                given = ContactCoefficients(*load(s, i, width, given_rows))
                speed = peek(s, (now + SPEED) * width + i)
                poke(s, force * width + i, lugre_force_step(state, peek(s, vibrated * width + i), speed, given))
        else:
            for i in range(count(n)):
                z = peek(s, (contact + 2) * width + i)
                poke(s, force * width + i, peek(s, given_rows[6] * width + i) * z)
        if law == slider:
            # Under a falling limit its bristle has slid with that of the middle of the substep.
            for i in range(count(n)):
                f, limit = peek(s, force * width + i), peek(s, vibrated * width + i)
                poke(s, force * width + i, min(max(f, -limit), limit))
        for i in range(count(n)):
            poke(s, friction_row * width + i, peek(s, (now + DIRECTION) * width + i) * peek(s, force * width + i))

    return settle, tell
