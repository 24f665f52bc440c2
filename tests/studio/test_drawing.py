"""What takes long is drawn and compiled beside the session: frames go on meanwhile."""

from __future__ import annotations

import json
import time
import warnings

import pytest
from live_engines import GRATING, Echo

import frictionloop as fl
from frictionloop.live.engines import TwinEngine
from frictionloop.live.session import Session
from frictionloop.studio import background
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
