"""What a page can ask for, by name, and how another System is put in force; every value is checked.

None reaches the file system. A loop that has to be compiled is compiled beside the session, and put in force when it is
ready.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeVar

from frictionloop.parameters import System
from frictionloop.parameters.presets import RETUNED
from frictionloop.physics.fingers import fingers
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.studio.connections import Guest, why_of
from frictionloop.studio.effect_pictures import effects
from frictionloop.studio.parallel_fingers import POPULATION_SEED
from frictionloop.studio.room import Room

T = TypeVar("T")


def number(asked: dict[str, Any], name: str, low: float, high: float) -> float:
    """Return a number within its limits."""
    value = asked.get(name)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise must_be(name, value, f"{low:g} to {high:g}")
    return float(value)


def flag(asked: dict[str, Any], name: str) -> bool:
    """Return yes or no."""
    if not isinstance(value := asked.get(name), bool):
        raise must_be(name, value, "true or false")
    return value


class Preset(NamedTuple):
    """What a button puts in force."""

    name: str
    told: str
    values: dict[str, Any]


LAW = {"controller.kind": "notch_pi", "controller.feedforward": True}
PRESETS = (
    Preset("Recommended law", "PI with notch and feed-forward.", LAW),
    Preset("Paper's gains", "The printed gains: it rings.", {
        "controller.kind": "pi", "controller.kp": 10.0, "controller.ki": 2.0}),
    Preset("Gains that hold", "PI retuned for this bench.", {
        "controller.kind": "pi", **RETUNED}),
    Preset("Usual finger", "0.95 N, as the controller believes.", {
        "friction.nominal_n": 0.95}),
    Preset("Sticky finger", "1.3 N, the controller believes 0.95.", {
        "friction.nominal_n": 1.3}),
    Preset("Slippery finger", "0.35 N, little for most wishes.", {
        "friction.nominal_n": 0.35}),
    Preset("Weak plate", "Half of the paper's amplitude.", {
        "plate.max_amplitude_um": 1.2}),
    Preset("Full plate", "2.5 um, as the paper's plate.", {
        "plate.max_amplitude_um": 2.5}),
)  # fmt: skip
BY_NAME = {each.name: each for each in PRESETS}


SOON_S = 0.4
"""A loop that is ready so soon is not spoken of."""
WAITS = "Compiling, once."


async def put_when_ready(room: Room, make: Callable[[System], System], remember: bool) -> None:
    """Let the engine compile what a System needs, and put in force what ``make`` then makes of the System there is.

    Pages are told that it takes its time, and why it cannot be if it cannot.
    """
    engine: Any = room.session.engine
    try:
        system = make(engine.system)
        work = asyncio.ensure_future(asyncio.to_thread(engine.prepare, system))
        done, _ = await asyncio.wait({work}, timeout=SOON_S)
        if not done:
            room.tell({"type": "said", "why": WAITS})
        await work
        room.put(make(engine.system), remember)
        room.tell_status()
    except Exception as error:  # what does not compile must not take the session with it
        room.tell({"type": "refused", "why": why_of(error)})


def change(room: Room, make: Callable[[System], System], remember: bool = True) -> None:
    """Put a System in force, made of the one that is: at once, or when its loop has been compiled."""
    system = make(room.session.engine.system)
    ready = getattr(room.session.engine, "ready", None)  # an engine that compiles nothing has none
    if ready is None or ready(system):
        room.put(system, remember)
    else:
        room.later(put_when_ready(room, make, remember))


def one_of(known: Mapping[str, T], asked: Any, name: str = "name") -> T:
    """Return what is asked for by its name."""
    which = asked.get(name) if isinstance(asked, dict) else None
    if not isinstance(which, str) or which not in known:
        raise must_be(name, which, f"one of {', '.join(known)}")
    return known[which]


def _effect(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    effect = one_of(effects(), asked)
    change(room, lambda system: system.evolve({"setpoint.effect": effect}))


def _set(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    values = asked.get("values")
    if not isinstance(values, dict) or not 0 < len(values) <= 64:
        raise must_be("values", values, "1 to 64 values by name")
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
    else:
        room.end_tour()


def _preset(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    preset = one_of(BY_NAME, asked)
    change(room, lambda system: system.evolve(preset.values))


def _finger(room: Room, guest: Guest, asked: dict[str, Any]) -> None:
    """Another finger of the population: of number n, the same one each time."""
    which = int(number(asked, "number", 0, 999))
    person = fingers(which + 1, POPULATION_SEED)[which]
    change(room, lambda system: system.evolve(person))


FREE = ("stop", "take", "sound", "crowd", "reach", "here")
"""Commands of every page; all others are the driving page's."""


def obey(room: Room, guest: Guest, asked: Any) -> None:
    """Do what a page asks for."""
    command, name = one_of(COMMANDS, asked, "do"), asked["do"]
    if name not in FREE and guest is not room.driver:
        raise FrictionloopError(f"{name}: another page drives")
    command(room, guest, asked)
    if name != "here":
        room.tell_status()


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


COMMANDS: dict[str, Callable[[Room, Guest, dict[str, Any]], None]] = {
    "stop": lambda room, guest, asked: room.session.stop(),
    "go": lambda room, guest, asked: room.session.go(),
    "here": lambda room, guest, asked: None,
    "arm": lambda room, guest, asked: room.session.arm(asked.get("state", "closed")),
    "clear": lambda room, guest, asked: room.session.clear(),
    "take": lambda room, guest, asked: room.take(guest),
    "lift": lambda room, guest, asked: room.session.lift(),
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
