"""A finger that turns round within its contacts, beside the answer of a sweep, which is no result yet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from frictionloop.cli import screen

if TYPE_CHECKING:
    from frictionloop.parameters import System

SPEED = "motion.speed_mm_s"


def ask(system: System, axes: Mapping[str, Sequence[Any]] | None = None) -> None:
    """Note it, for stderr; of a sweep over speeds that of the first that has it."""
    from frictionloop.loop.run_findings import contact_turns

    speeds = (axes or {}).get(SPEED, ())
    each_found = (list(contact_turns(system.evolve({SPEED: speed}))) for speed in speeds)
    screen.note_findings(next(filter(None, each_found), []) if len(speeds) else contact_turns(system))
