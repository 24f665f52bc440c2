"""What takes long is drawn and compiled beside the session: frames go on meanwhile."""

from __future__ import annotations

import asyncio
import gc
import json
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor

import pytest
from live_engines import GRATING, Echo

import frictionloop as fl
from frictionloop.live.live_engines import TwinEngine
from frictionloop.live.live_session import Session
from frictionloop.quantities import FrictionloopError
from frictionloop.studio import background, commands
from frictionloop.studio.commands import obey
from frictionloop.studio.connections import Guest
from frictionloop.studio.room import Room
from frictionloop.studio.server import studio_app

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # starlette would have another client than httpx
    from starlette.testclient import TestClient

MAP, FRAME = 2, 1


def kinds(live, until):
    """Return the kinds of the messages up to one that is waited for."""
    found = []
    while until not in found:
        message = live.receive()
        text = message.get("text")
        found.append(json.loads(text)["type"] if text is not None else message["bytes"][0])
    return found


@pytest.fixture
def slowly(monkeypatch):
    """Let a map take 0.3 s; yields the effects that were drawn."""
    drawn, quick = [], background.map_of

    def slow(system):
        drawn.append(system.setpoint.effect)
        time.sleep(0.3)
        return quick(system)

    monkeypatch.setattr(background, "map_of", slow)
    return drawn


def test_frames_go_on_while_a_map_is_drawn_and_the_newest_effect_is_drawn_last(slowly):
    app = studio_app(Room(Session(Echo())))
    with TestClient(app, base_url="http://localhost") as at, at.websocket_connect("ws://localhost/live") as live:
        kinds(live, MAP)
        for name in ("bump", "edge", "hole"):
            live.send_text(json.dumps({"do": "effect", "name": name}))
        meanwhile = kinds(live, MAP)
    assert meanwhile.count(FRAME) > 20
    # The one in the middle was never drawn, or not told: only the last is on the plate.
    assert slowly[-1] == fl.rendering.LIBRARY["hole"]
    assert len(slowly) <= 3


def test_a_number_is_in_force_at_once_and_an_effect_of_a_new_kind_is_prepared_first():
    engine = TwinEngine(GRATING)
    assert engine.ready(GRATING.evolve({"friction.nominal_n": 1.3, "controller.delay_s": 1e-4}))
    assert engine.ready(GRATING.evolve({"setpoint.effect.spacing_mm": 4.0}))
    bump = GRATING.evolve({"setpoint.effect": fl.rendering.LIBRARY["bump"]})
    assert not engine.ready(bump)
    engine.prepare(bump)
    assert engine.ready(bump)
    assert engine.system == GRATING


# Another loop is compiled beside the session: it goes on, is told of, and what cannot be leaves it as it is.


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


# What opens the page loads little, and the rest comes beside the session.


OPENS = """
import sys
import frictionloop as fl
from frictionloop.live.live_engines import TwinEngine
from frictionloop.live.live_session import Session
from frictionloop.studio.room import Room
from frictionloop.studio.server import studio_app
studio_app(Room(Session(TwinEngine(fl.bench().evolve({"setpoint": {"kind": "effect"}})))))
heavy = {"xarray", "pandas", "h5py", "scipy.signal", "scipy.ndimage", "scipy.stats"}
print("loaded:", *sorted(heavy & set(sys.modules)))
from frictionloop.studio import background
background.load()
print("loaded:", *sorted(heavy & set(sys.modules)))
"""


@pytest.mark.slow
def test_what_opens_the_page_loads_no_filters_and_no_datasets():
    ran = subprocess.run([sys.executable, "-c", OPENS], capture_output=True, text=True, check=True)
    assert ran.stdout.splitlines() == ["loaded:", "loaded: h5py pandas scipy.ndimage scipy.signal scipy.stats xarray"]


def test_what_a_session_has_loaded_is_not_searched_for_garbage(monkeypatch):
    frozen, before = gc.get_freeze_count(), [[] for _ in range(1000)]
    with background.starting():
        assert not gc.isenabled()
        background.started()
        assert gc.isenabled()
        started, made = gc.get_freeze_count(), [[] for _ in range(1000)]
        assert started >= frozen + len(before)
        monkeypatch.delitem(sys.modules, background.MODULES[-1], raising=False)
        background.load()
        assert gc.get_freeze_count() >= started + len(made)
        monkeypatch.setattr(gc, "freeze", lambda: pytest.fail("loaded again"))
        background.load()  # for every count
    assert gc.isenabled()
