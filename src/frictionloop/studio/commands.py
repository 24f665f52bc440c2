"""What a page can ask for, by name; every command is checked here, and none reaches the file system."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from frictionloop.parameters import System
from frictionloop.physics.fingers import fingers
from frictionloop.quantities import FrictionloopError
from frictionloop.studio.crowd import POPULATION_SEED
from frictionloop.studio.gallery import effects
from frictionloop.studio.guest import Guest
from frictionloop.studio.preparing import is_ready, put_when_ready
from frictionloop.studio.presets import BY_NAME
from frictionloop.studio.room import Room
from frictionloop.studio.share import system_message

FREE = ("stop", "take", "sound", "crowd", "reach", "here")
"""Commands of every page; all others are the driving page's."""


def obey(room: Room, guest: Guest, asked: Any) -> None:
    """Do what a page asks for.

    Raises
    ------
    FrictionloopError
        For what is no command, another page's affair, or a value that does not fit.
    """
    name = asked.get("do") if isinstance(asked, dict) else None
    if not isinstance(name, str) or name not in COMMANDS:
        raise FrictionloopError(f"do = {name!r:.40}: must be one of {', '.join(COMMANDS)}")
    if name not in FREE and guest is not room.driver:
        raise FrictionloopError(f"{name}: another page drives; take over first")
    COMMANDS[name](room, guest, asked)
    if name != "here":
        room.tell_status()


def _number(asked: dict[str, Any], name: str, low: float, high: float) -> float:
    value = asked.get(name)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise FrictionloopError(f"{name} = {value!r:.40}: must be a number from {low:g} to {high:g}")
    return float(value)


def _flag(asked: dict[str, Any], name: str) -> bool:
    if not isinstance(value := asked.get(name), bool):
        raise FrictionloopError(f"{name} = {value!r:.40}: must be true or false")
    return value


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


def _stop(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    room.session.stop()


def _go(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    room.session.go()


def _here(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    """Nothing but that the page is there, which the room takes note of with every message."""


def _arm(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    room.session.arm(asked.get("state", "closed"))


def _clear(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    room.session.clear()


def _take(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    room.take(guest)


def _lift(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    room.session.lift()


def _ghost(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    room.session.ghost_on = _flag(asked, "on")


def _ghost_speed(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    room.session.ghost.speed_mm_s = _number(asked, "mm_s", 2.0, 300.0)


def _load(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    room.session.load_n = _number(asked, "load_n", 0.05, 5.0)


def _sound(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    guest.listens = _flag(asked, "on")


def _crowd(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    guest.crowd = _flag(asked, "on")


def _reach(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    guest.ahead = _flag(asked, "on")
    if guest.ahead and room.reach.told is not None:
        guest.put(room.reach.told)


def _effect(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    name = asked.get("name")
    known = effects()
    if not isinstance(name, str) or name not in known:
        raise FrictionloopError(f"name = {name!r:.40}: must be one of {', '.join(known)}")
    change(room, lambda system: system.evolve({"setpoint.effect": known[name]}))


def _set(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    values = asked.get("values")
    if not isinstance(values, dict) or not 0 < len(values) <= 64:
        raise FrictionloopError("values: must be dotted names and their values, at most 64")
    check_no_file(values)
    change(room, lambda system: system.evolve(values))


def check_no_file(values: Any) -> None:
    """Refuse what would read a file: recordings, and effects by the name of one. Nothing else of a System is a path."""
    for name, value in values.items() if isinstance(values, dict) else enumerate(values):
        if str(name).rpartition(".")[2] == "path" or (isinstance(value, str) and set(value) & set("./\\")):
            raise FrictionloopError(f"{name} = {value!r:.40}: names a file, and a page does not reach the file system")
        if isinstance(value, (dict, list)):
            check_no_file(value)


def _undo(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    if not room.before:
        raise FrictionloopError("undo: nothing has been changed")
    before = room.before.pop()
    change(room, lambda _: before, remember=False)


def _tour(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    """Remember what is in force before a tour, and put it in force again after it."""
    if _flag(asked, "on"):
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
    number = int(_number(asked, "number", 0, 999))
    person = fingers(number + 1, POPULATION_SEED)[number]
    change(room, lambda system: system.evolve(person))


Command = Callable[[Room, Guest, dict[str, Any]], None]
COMMANDS: dict[str, Command] = {
    "stop": _stop,
    "go": _go,
    "here": _here,
    "arm": _arm,
    "clear": _clear,
    "take": _take,
    "lift": _lift,
    "ghost": _ghost,
    "ghost_speed": _ghost_speed,
    "load": _load,
    "sound": _sound,
    "crowd": _crowd,
    "reach": _reach,
    "effect": _effect,
    "set": _set,
    "undo": _undo,
    "tour": _tour,
    "preset": _preset,
    "finger": _finger,
}
