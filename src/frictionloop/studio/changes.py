"""What a page changes of the System in force, by name; every value is checked, and none reaches the file system."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from frictionloop.parameters import System
from frictionloop.physics.fingers import fingers
from frictionloop.quantities import FrictionloopError
from frictionloop.studio.asked import flag, number
from frictionloop.studio.crowd import POPULATION_SEED
from frictionloop.studio.gallery import effects
from frictionloop.studio.guest import Guest
from frictionloop.studio.preparing import is_ready, put_when_ready
from frictionloop.studio.presets import BY_NAME
from frictionloop.studio.room import Room
from frictionloop.studio.share import system_message


def change(room: Room, make: Callable[[System], System], remember: bool = True) -> None:
    """Put a System in force, made of the one that is: at once, or when its loop has been compiled."""
    system = make(room.session.engine.system)
    if is_ready(room, system):
        put(room, system, remember)
    else:
        room.later(put_when_ready(room, make, lambda made: put(room, made, remember)))


def put(room: Room, system: System, remember: bool) -> None:
    """Put a System in force, and tell every page; what was there can be had again by undo."""
    before = room.session.engine.system
    went_on = room.session.change(system)
    if remember:
        room.before.append(before)
    room.redraw()
    room.tell(system_message(system) | {"restarted": not went_on})


def _effect(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    name = asked.get("name")
    known = effects()
    if not isinstance(name, str) or name not in known:
        raise FrictionloopError(f"name = {name!r:.40}: must be one of {', '.join(known)}")
    change(room, lambda system: system.evolve({"setpoint.effect": known[name]}))


def _set(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    values = asked.get("values")
    if not isinstance(values, dict) or not 0 < len(values) <= 64:
        raise FrictionloopError("values: must be at most 64")
    check_no_file(values)
    change(room, lambda system: system.evolve(values))


def check_no_file(values: Any) -> None:
    """Refuse what would read a file: recordings, and effects by the name of one. Nothing else of a System is a path."""
    for name, value in values.items() if isinstance(values, dict) else enumerate(values):
        if str(name).rpartition(".")[2] == "path" or (isinstance(value, str) and set(value) & set("./\\")):
            raise FrictionloopError(f"{name} = {value!r:.40}: must not be a file")
        if isinstance(value, (dict, list)):
            check_no_file(value)


def _undo(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    if not room.before:
        raise FrictionloopError("undo: nothing has been changed")
    before = room.before.pop()
    change(room, lambda _: before, remember=False)


def _tour(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    """Remember what is in force before a tour, and put it in force again after it."""
    if flag(asked, "on"):
        room.before_tour = room.session.engine.system
    elif (before := room.before_tour) is not None:
        room.before_tour = None
        change(room, lambda _: before)


def _preset(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    name = asked.get("name")
    if not isinstance(name, str) or name not in BY_NAME:
        raise FrictionloopError(f"name = {name!r:.40}: must be one of {', '.join(BY_NAME)}")
    change(room, lambda system: system.evolve(BY_NAME[name].values))


def _finger(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    """Another finger of the population: of number n, the same one each time."""
    which = int(number(asked, "number", 0, 999))
    person = fingers(which + 1, POPULATION_SEED)[which]
    change(room, lambda system: system.evolve(person))


CHANGES: dict[str, Callable[[Room, Guest, dict[str, Any]], None]] = {
    "effect": _effect,
    "set": _set,
    "undo": _undo,
    "tour": _tour,
    "preset": _preset,
    "finger": _finger,
}
