"""What a change does to Fig. 5a that its numbers alone do not say, in lines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from frictionloop.parameters import System
from frictionloop.physics.fingers import fingers
from frictionloop.quantities import FrictionloopError, unit_of
from frictionloop.report.device import CONTROLLERS, IDEAL, OPEN

SPEED = "motion.speed_mm_s"


def told(changes: Mapping[str, Any], base: System, rows: Mapping[str, Any]) -> list[str]:
    """Return the lines.

    Parameters
    ----------
    changes
        What was changed, by dotted names.
    base
        The bench with the protocol's finger, not changed.
    rows
        The controllers of the figure, by name.
    """
    return [
        *_own(changes, base),
        *_speed(changes, base, rows),
        *_delay(changes, base),
        *_unreached(changes, base, rows),
    ]


def _own(changes: Mapping[str, Any], base: System) -> list[str]:
    """Return what this finger had in the place of values that a finger brings."""
    said = []
    for path in (each for each in changes if each in fingers(1, 0)[0]):
        block, name = path.split(".")
        said.append(f"{path} = {getattr(getattr(base, block), name):.3g} {unit_of(path) or ''}".rstrip())
    return [f"this finger's own, which the change replaces: {', '.join(said)}"] if said else []


def _speed(changes: Mapping[str, Any], base: System, rows: Mapping[str, Any]) -> list[str]:
    """Return that the friction of the finger itself changes with the speed."""
    there = base.evolve(changes)
    friction: Any = there.friction  # of a finger, which the protocol sets
    slope = float(friction.speed_slope)
    if not slope or there.motion.speed_mm_s == base.motion.speed_mm_s:  # type: ignore[union-attr]
        return []
    does = "rises" if slope > 0 else "falls"
    what = "the open loop" if OPEN in rows else "what the controllers work against"
    return [f"this finger's friction {does} with speed, friction.speed_slope = {slope:.3g}: {what} changes with it"]


def _delay(changes: Mapping[str, Any], base: System) -> list[str]:
    """Return the delay with what the hold adds to it."""
    before, now = base.controller, base.evolve(changes).controller
    if (now.delay_s, now.rate_hz) == (before.delay_s, before.rate_hz):
        return []
    whole_ms = 1e3 * (now.delay_s + 0.5 / now.rate_hz)
    return [f"controller.delay_s = {now.delay_s:g}, with half a period of hold: {whole_ms:.3g} ms in all"]


def _unreached(changes: Mapping[str, Any], base: System, rows: Mapping[str, Any]) -> list[str]:
    """Return which changes the ideal sensor takes away again."""
    if IDEAL not in rows:
        return []
    paths = [path for path, to in changes.items() if _taken_away({path: to}, base)]
    return [f'{" and ".join(paths)} {"do" if len(paths) > 1 else "does"} not reach "{IDEAL}"'] if paths else []


def _taken_away(change: Mapping[str, Any], base: System) -> bool:
    ideal = CONTROLLERS[IDEAL]
    try:
        return base.evolve(change).evolve(ideal) == base.evolve(ideal)
    except FrictionloopError:  # has a meaning only beside another one, as noise_rms_n beside its kind of sensor
        return False
