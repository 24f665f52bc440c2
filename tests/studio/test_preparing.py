"""Another loop is compiled beside the session: it goes on, is told of, and what cannot be leaves it as it is."""

from __future__ import annotations

import asyncio
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from live_engines import GRATING, Echo

import frictionloop as fl
from frictionloop.live.engines import TwinEngine
from frictionloop.live.session import Session
from frictionloop.quantities import FrictionloopError
from frictionloop.studio import commands
from frictionloop.studio.commands import obey
from frictionloop.studio.connections import Guest
from frictionloop.studio.room import Room


class Slow(Echo):
    """An engine that compiles another law for as long as it is not let go."""

    def __init__(self, fails=None):
        super().__init__()
        self.let_go, self.fails = threading.Event(), fails

    def ready(self, system):
        return system.controller.kind == GRATING.controller.kind

    def prepare(self, system):
        self.let_go.wait(10)
        if self.fails:
            raise self.fails


def run(work):
    """Run a coroutine in a thread of its own: the browser of other tests has a loop in this one."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, work).result()


def told(guest, kind):
    return [each for each in guest._waiting if isinstance(each, dict) and each["type"] == kind]


async def asked(engine, monkeypatch, meanwhile):
    monkeypatch.setattr(commands, "SOON_S", 0.01)
    room, guest = Room(Session(engine)), Guest(True)
    room.join(guest)
    obey(room, guest, {"do": "set", "values": {"controller.kind": "pi"}})
    await asyncio.sleep(0.05)
    meanwhile(room, guest)
    engine.let_go.set()
    while room._doing:
        await asyncio.sleep(0.01)
    return room, guest


def test_the_session_goes_on_until_the_other_loop_is_ready(monkeypatch):
    def meanwhile(room, guest):
        assert told(guest, "said")[0]["why"] == commands.WAITS
        assert room.session.engine.system == GRATING
        obey(room, guest, {"do": "set", "values": {"friction.nominal_n": 1.1}})

    room, _ = run(asked(Slow(), monkeypatch, meanwhile))
    assert room.session.engine.system == GRATING.evolve({"friction.nominal_n": 1.1, "controller.kind": "pi"})
    assert [each.controller.kind for each in room.before] == ["limit_observer", "limit_observer"]


@pytest.mark.parametrize("error", [FrictionloopError("no such loop"), ValueError("no such loop")])
def test_what_cannot_be_compiled_leaves_the_loop_that_was(monkeypatch, error):
    room, guest = run(asked(Slow(error), monkeypatch, lambda *_: None))
    assert "no such loop" in told(guest, "refused")[0]["why"]
    assert room.session.engine.system == GRATING
    assert not room.dead


@pytest.mark.slow
def test_numbers_are_taken_at_once_and_another_law_or_kind_of_effect_is_not():
    engine = TwinEngine(GRATING)
    assert engine.ready(GRATING.evolve({"friction.nominal_n": 1.3, "controller.delay_s": 1e-4}))
    assert engine.ready(GRATING.evolve({"setpoint.effect.spacing_mm": 4.0}))
    for change in ({"controller.kind": "pi"}, {"setpoint.effect": fl.rendering.LIBRARY["rough"]}):
        other = GRATING.evolve(change)
        assert not engine.ready(other)
        engine.prepare(other)
        assert engine.ready(other)
    assert engine.system == GRATING
