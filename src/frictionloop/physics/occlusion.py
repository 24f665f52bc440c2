"""How moist contacts leave a finger: occlusion rises on the plate and falls in the air."""

from __future__ import annotations

import math

from frictionloop.parameters.plant import FingerFriction


def occlusion_after(friction: FingerFriction, contact_s: float, lifted_s: float, contacts: float = 1.0) -> float:
    """Return how far occlusion has come, 0 to 1, at the end of the last of some contacts of a finger that was dry.

        w = (1 - a) (1 - (a b)^n) / (1 - a b),   a = e^(-contact/occlusion_s),   b = e^(-lifted/drying_s)

    Parameters
    ----------
    friction
        Of the finger; its time constants count.
    contact_s, lifted_s
        Time on the plate, and in the air before the next contact, s.
    contacts
        How many, at least 1; infinite is where it ends.
    """
    on = contact_s / friction.occlusion_s
    both = on + lifted_s / friction.drying_s
    if contacts == 1.0 or both == 0.0:
        return -math.expm1(-on)
    return math.expm1(-on) / math.expm1(-both) * -math.expm1(-contacts * both)


def occlusion_at(friction: FingerFriction, contact_s: float, lifted_s: float, time_s: float) -> float:
    """Return how far occlusion has come in the present or last contact of a finger that landed dry at 0, 0 to 1.

    Parameters
    ----------
    friction
        Of the finger; its time constants count.
    contact_s, lifted_s
        Time on the plate, 0 of one that never lifts, and in the air before the next contact, s.
    time_s
        Since it landed first, s.
    """
    if contact_s == 0.0:
        return occlusion_after(friction, time_s, 0.0)
    contacts, since_s = divmod(time_s, contact_s + lifted_s)
    before = occlusion_after(friction, contact_s, lifted_s, contacts) * math.exp(-lifted_s / friction.drying_s)
    return 1.0 - (1.0 - before * (contacts > 0)) * math.exp(-min(since_s, contact_s) / friction.occlusion_s)
