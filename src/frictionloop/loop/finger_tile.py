"""The tile of a substep of the bench: plate, friction limit and contact under a held command."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.motion_tile import FACTOR, OCCLUDED, SPEED
from frictionloop.loop.slab import ROW, load, peek, poke, rows, store
from frictionloop.loop.tiles import Lifting
from frictionloop.physics.contact import ContactCoefficients, ContactState
from frictionloop.physics.friction_limit import vibrated_step
from frictionloop.physics.plate import limit_step, lowpass_step
from frictionloop.quantities.arithmetic import fma, step


@step
def rigid_step(
    state: ContactState, limit_n: float, speed_m_s: float, coefficients: ContactCoefficients
) -> tuple[ContactState, float]:
    """Friction without skin: the force is at its limit and opposes the motion, forwards if there is none."""
    return state, limit_n if speed_m_s >= 0.0 else -limit_n


def build_finger(lifting: Lifting, law: Any) -> Any:
    """Lift plate, friction limit and a contact law over one substep; ``fraction`` says where in the period it lies.

    ``phase`` is 0 before the command changes and 1 after. Speed and limit are linear between control periods.
    """
    width, compiled, count = lifting
    now, after, limit_row, loss = ROW["motion"], ROW["motion_next"], ROW["limit_n"], ROW["moist_loss"]
    decay, amplitude, held_row, halving = (
        ROW["amplitude_decay"],
        ROW["amplitude"],
        ROW["held"],
        ROW["halving_amplitude"],
    )
    state_rows, force, given_rows = rows("contact"), ROW["contact_force"], rows("contact_coefficients")

    @compiled
    def between(s, i, row, fraction):  # type: ignore[no-untyped-def]
        value = peek(s, (now + row) * width + i)
        return fma(fraction, peek(s, (after + row) * width + i) - value, value)

    def for_phase(phase: int) -> Any:
        coefficient_rows = given_rows[10 * phase : 10 * (phase + 1)]

        @compiled
        def finger(s, n, fraction):  # type: ignore[no-untyped-def]
            for i in range(count(n)):
                a, held = peek(s, amplitude * width + i), peek(s, held_row * width + i)
                middle = lowpass_step(a, held, peek(s, (decay + 2 * phase) * width + i))
                y = middle * peek(s, (halving + 1) * width + i)
                occluded = peek(s, (now + OCCLUDED) * width + i)
                left = vibrated_step(y, occluded, peek(s, loss * width + i))
                limit = peek(s, limit_row * width + i) * between(s, i, FACTOR, fraction) * left
                speed = between(s, i, SPEED, fraction)
                given = ContactCoefficients(*load(s, i, width, coefficient_rows))
                state, f = law(ContactState(*load(s, i, width, state_rows)), limit, speed, given)
                store(s, i, width, state_rows, state)
                poke(s, force * width + i, f)
                whole = peek(s, (decay + 2 * phase + 1) * width + i)
                poke(s, amplitude * width + i, lowpass_step(a, held, whole))

        return finger

    return for_phase(0), for_phase(1)


def build_hold(lifting: Lifting) -> Any:
    """Return the tile that takes the command of a row into force.

    The substeps then read it from a row of fixed number: of a row that varies the compiler could not know that they do
    not write it.
    """
    width, compiled, count = lifting
    held, ceiling = ROW["held"], ROW["max_amplitude"]

    @compiled
    def hold(s, n, command):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            poke(s, held * width + i, limit_step(peek(s, command * width + i), peek(s, ceiling * width + i)))

    return hold
