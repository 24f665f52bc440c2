"""A finger that turns round within its contacts: how each contact becomes one stroke, which turns in the air."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from frictionloop.cli import screen
from frictionloop.firmware.board_fit import scale_for
from frictionloop.parameters import Strokes, System
from frictionloop.parameters.motion import one_stroke_a_contact

SEVERAL = 2.0
"""Strokes of a contact from which on it is meant to be back and forth (chosen)."""
SPEED = "motion.speed_mm_s"


def ask(system: System, axes: Mapping[str, Sequence[Any]] | None = None) -> None:
    """Note the question, for stderr: of a run, since a design has no turns.

    Of a sweep over ``motion.speed_mm_s`` it is asked of the first speed that has it; other axes are not looked at.
    """
    speeds = (axes or {}).get(SPEED, ())
    if not len(speeds) and (said := question(system)):
        screen.note(said)
    for speed_mm_s in speeds:
        if said := question(system.evolve({SPEED: speed_mm_s})):
            screen.note(f"with {SPEED} = {speed_mm_s:g}: {said}. Each speed has its own path: sweep one at a time")
            return


def beside(stroke_mm: float, system: System) -> dict[str, float]:
    """Return what a stroke takes besides: a longer plate, and for a board the scale that reads all of it."""
    longer = {"touch.load.length_mm": stroke_mm} if stroke_mm > system.touch.load.length_mm else {}
    return longer | scale_for(stroke_mm, system)


def question(system: System) -> str:
    """Return what is told of strokes that end within contacts.

    Empty of a finger that stays, goes back and forth within a contact, or turns in the air.
    """
    motion = system.motion
    if not isinstance(motion, Strokes) or motion.contact_s == 0.0:
        return ""
    half_s = 0.5 * motion.cycle_s
    if one_stroke_a_contact(motion) or motion.contact_s >= SEVERAL * half_s:
        return ""
    changes = motion.in_contacts()
    stroke_mm = changes["motion.stroke_mm"]
    changes |= beside(stroke_mm, system)
    flags = " ".join(f"--{path} {value:.6g}" for path, value in changes.items())
    long = f", on a plate of {stroke_mm:.3g} mm" if "touch.load.length_mm" in changes else ""
    return (
        f"motion.contact_s is {motion.contact_s:g} s and a stroke lasts {half_s:.3g} s, so the finger turns round on "
        f"the plate within its contacts; if each contact is to be one stroke that turns in the air{long}: {flags}"
    )
