"""A finger on the plate as steps: how it moves on, one substep of plate, limit and contact, and what is told of it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from frictionloop.physics.bristle_contact import ContactCoefficients, ContactState, bristle_step
from frictionloop.physics.limit_scaling import (
    LimitCoefficients,
    OcclusionCoefficients,
    aged_step,
    ageing_step,
    limit_step,
    occlusion_step,
)
from frictionloop.physics.motion import LoadPlan, StrokePlan, load_step, stroke_step
from frictionloop.physics.plate import plate_step
from frictionloop.physics.tremor import TremorState
from frictionloop.physics.vibration import GAUSSIAN, Vibration
from frictionloop.quantities.scalar_math import fma, step


class Motion(NamedTuple):
    """A finger at one time."""

    position: float
    """m; m/s and N below."""
    speed: float
    load: float
    factor: float
    """On f0, from load, speed, moisture and place."""
    occluded: float
    direction: float
    """Of the stroke, 1 or -1; at rest the last there was."""
    place: float
    """Along the stroke without tremor, m."""


LEAST_M_S = 1e-300
"""Speed of a finger at rest along its direction, so that a rigid one's force keeps its sign; lost in any other."""


@step
def move_step(
    t: float, direction: float, stroke: StrokePlan, plan: LoadPlan, along: TremorState, across: TremorState
) -> tuple[float, float, float, float, float]:
    """Position, speed, load, direction and place at time t, after a ``direction``: the stroke, and the tremor on it."""
    place, speed = stroke_step(t, stroke)
    pressed = load_step(t, across.displacement, plan)
    return place + along.displacement, speed + along.rate, pressed, heading_step(speed, direction), place


@step
def heading_step(speed_m_s: float, direction: float) -> float:
    """Sign of the speed; at rest the last direction."""
    return 1.0 if speed_m_s > 0.0 else (-1.0 if speed_m_s < 0.0 else direction)


@step
def scored_step(place_m: float, load_n: float, edge_m: float, least_n: float) -> float:
    """1 where a period counts: within the stroke's plateau, and pressed."""
    return 1.0 if (abs(place_m) <= edge_m) & (load_n >= least_n) else 0.0


@step
def factor_step(  # type: ignore[no-untyped-def]
    load_n, speed_m_s, occluded, rough, occlusion: OcclusionCoefficients, limit: LimitCoefficients
) -> tuple[float, float]:
    """Moisture a period on, and the factor on f0 then."""
    occluded = occlusion_step(occluded, load_n, occlusion)
    return occluded, limit_step(load_n, speed_m_s, occluded, rough, limit)


@step
def landed_step(load_n: float, speed_m_s: float, rough: float, limit: LimitCoefficients) -> tuple[float, float]:
    """The same at t = 0, dry."""
    return 0.0, limit_step(load_n, speed_m_s, 0.0, rough, limit)


@step
def rigid_step(
    state: ContactState, limit_n: float, speed_m_s: float, coefficients: ContactCoefficients
) -> tuple[ContactState, float]:
    """Friction without skin: the force is at its limit and opposes the motion, forwards if there is none."""
    return state, limit_n if speed_m_s >= 0.0 else -limit_n


CONTACTS = {"rigid": rigid_step, "bristle": bristle_step}
"""Contact laws by name: state and mean force over a step."""


def substep_of(contact: str, vibration: Vibration) -> Any:
    """Return the step of plate, friction limit and a contact law over substep ``j`` ``of`` a period.

    Speed and limit are linear between control periods. In the substep in which the command changes the plate sees its
    mean, which errs by 1/8 (substep times plate bandwidth)^2 of the change.
    """
    law, remaining = CONTACTS[contact], vibration.step
    trusted = vibration is GAUSSIAN  # of a law from outside no number, or less than none, must not pass for no friction

    @step
    def substep(j, of, now, after, old, new, switch, ceiling, a, plate, effect, limit_n, ageing, before, given):  # type: ignore[no-untyped-def]
        fraction = (j + 0.5) / of
        share = min(max(j + 1.0 - switch * of, 0.0), 1.0)
        middle, end = plate_step(a, fma(share, new - old, old), ceiling, plate)
        left = remaining(middle, now.occluded, effect)
        limit = limit_n * fma(fraction, after.factor - now.factor, now.factor) * left
        speed = fma(now.direction, LEAST_M_S, fma(fraction, after.speed - now.speed, now.speed))
        age = ageing_step(before.age_s, speed - before.lag_speed_m_s, limit, given.dt, ageing)
        aged = ContactState(before.lag_m, before.lag_speed_m_s, before.force_n, age)
        state, force = law(aged, limit * aged_step(age, ageing), speed, given)
        return end, state, force if trusted or left >= 0.0 else math.nan

    return substep


def limits_of(vibration: Vibration) -> Any:
    """Return the step that tells the highest and the lowest friction of a finger, and its limit, at one time."""
    remaining = vibration.step

    @step
    def limits(limit_n, now, a, ceiling, effect, age_s, ageing):  # type: ignore[no-untyped-def]
        top = limit_n * now.factor
        floor = top * remaining(ceiling, now.occluded, effect)
        return top, floor, top * remaining(a, now.occluded, effect) * aged_step(age_s, ageing)

    return limits


@step
def rigid_force_step(limit_n: float, now: Motion, state: ContactState, given: ContactCoefficients) -> float:
    """Force without skin."""
    return limit_n if fma(now.direction, LEAST_M_S, now.speed) >= 0.0 else -limit_n


@step
def bristle_force_step(limit_n: float, now: Motion, state: ContactState, given: ContactCoefficients) -> float:
    """F of the bristle; without a length within the limit, which it followed to the middle of the substep."""
    most = limit_n + given.beyond
    return min(max(state.force_n, -most), most)


FORCES = {"rigid": rigid_force_step, "bristle": bristle_force_step}
"""Force of the contact laws at a time."""


def settled_of(contact: str) -> Any:
    """Return the step that puts a contact where it had time enough to be before t = 0.

    A finger slides at t = 0 if it goes at half the speed of its stroke or more; one at rest only trembles.
    """
    stiff = contact == "rigid"

    @step
    def settled(limit_n, now, full_speed, compliance):  # type: ignore[no-untyped-def]
        limit, slides = limit_n * now.factor, 0.5 * full_speed
        f = limit if now.speed >= slides else (-limit if now.speed <= -slides else 0.0)
        f = (limit if now.speed >= 0.0 else -limit) if stiff else f
        return f, f * compliance

    return settled
