"""What a page can ask for, by name; every command is checked here, and none reaches the file system."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from frictionloop.quantities import FrictionloopError
from frictionloop.studio.asked import flag, number
from frictionloop.studio.changes import CHANGES
from frictionloop.studio.guest import Guest
from frictionloop.studio.room import Room

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
        raise FrictionloopError(f"{name}: another page drives")
    COMMANDS[name](room, guest, asked)
    if name != "here":
        room.tell_status()


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
    room.session.ghost_on = flag(asked, "on")


def _ghost_speed(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    room.session.ghost.speed_mm_s = number(asked, "mm_s", 2.0, 300.0)


def _load(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    room.session.load_n = number(asked, "load_n", 0.05, 5.0)


def _sound(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    guest.listens = flag(asked, "on")


def _crowd(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    guest.crowd = flag(asked, "on")


def _reach(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    guest.ahead = flag(asked, "on")
    if guest.ahead and room.effect_watch.told is not None:
        guest.put(room.effect_watch.told)


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
    **CHANGES,
}
