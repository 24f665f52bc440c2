"""The tile of a substep of the bench: plate, friction limit and contact."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import load, peek, poke, store
from frictionloop.loop.kernel.motion_tile import FACTOR, OCCLUDED, SPEED
from frictionloop.loop.kernel.slab import ROW, rows, vibration_rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.physics.contact import ContactCoefficients, ContactState
from frictionloop.physics.contact_bristle import dahl_step, lugre_step
from frictionloop.physics.contact_slider import slider_step
from frictionloop.physics.friction_limit import static_step
from frictionloop.physics.plate import limit_step, lowpass_step
from frictionloop.physics.vibration import Vibration
from frictionloop.quantities.arithmetic import fma, step


@step
def rigid_step(
    state: ContactState, limit_n: float, speed_m_s: float, coefficients: ContactCoefficients
) -> tuple[ContactState, float]:
    """Friction without skin: the force is at its limit and opposes the motion, forwards if there is none."""
    return state, limit_n if speed_m_s >= 0.0 else -limit_n


CONTACT_STEPS = {"rigid": rigid_step, "dahl": dahl_step, "lugre": lugre_step, "slider": slider_step}


def lift_finger(lifting: Lifting, contact: str, vibration: Vibration) -> Any:
    """Lift plate, friction limit and a contact law over substep ``j`` ``of`` a period.

    Speed and limit are linear between control periods. In the substep in which the command changes the plate sees its
    mean, which errs by 1/8 (substep times plate bandwidth)^2 of the change.
    """
    width, compiled, count = lifting
    law, remaining, effect_rows = CONTACT_STEPS[contact], vibration.step, vibration_rows(vibration)
    now, after, limit_row = ROW["motion"], ROW["motion_next"], ROW["limit_n"]
    decay, amplitude, applied, switch = ROW["amplitude_decay"], ROW["amplitude"], ROW["applied"], ROW["switch"]
    ceiling = ROW["max_amplitude"]
    static_rows = rows("static")
    state_rows, force, given_rows = rows("contact"), ROW["contact_force"], rows("contact_coefficients")

    @compiled
    def between(s, i, row, fraction):  # type: ignore[no-untyped-def]
        value = peek(s, (now + row) * width + i)
        return fma(fraction, peek(s, (after + row) * width + i) - value, value)

    @compiled
    def finger(s, n, j, of):  # type: ignore[no-untyped-def]
        fraction = (j + 0.5) / of
        for i in range(count(n)):
            old, new = peek(s, applied * width + i), peek(s, (applied + 1) * width + i)
            share = min(max(j + 1.0 - peek(s, switch * width + i) * of, 0.0), 1.0)
            held = limit_step(fma(share, new - old, old), peek(s, ceiling * width + i))
            a = peek(s, amplitude * width + i)
            y = lowpass_step(a, held, peek(s, decay * width + i))
            poke(s, amplitude * width + i, lowpass_step(a, held, peek(s, (decay + 1) * width + i)))
            occluded = peek(s, (now + OCCLUDED) * width + i)
            left = remaining(y, occluded, load(s, i, width, effect_rows))
            limit = peek(s, limit_row * width + i) * between(s, i, FACTOR, fraction) * left
            speed = between(s, i, SPEED, fraction)
            before = ContactState(*load(s, i, width, state_rows))
            static_gain, per_static_speed = load(s, i, width, static_rows)
            limit = limit * static_step(speed - before.lag_speed_m_s, static_gain, per_static_speed)
            given = ContactCoefficients(*load(s, i, width, given_rows))
            state, f = law(before, limit, speed, given)
            store(s, i, width, state_rows, state)
            poke(s, force * width + i, f)

    return finger
