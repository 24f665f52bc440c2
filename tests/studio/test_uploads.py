"""What a page brings along is read within limits, asked about, and refused in one line."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from live_engines import GRATING, Echo
from studio_files import png, wav

import frictionloop as fl
from frictionloop.live.live_session import Session
from frictionloop.rendering.force_tables import Map
from frictionloop.studio.connections import Doors, Guest
from frictionloop.studio.effect_uploads import MOST_BYTES, PAINT_MM, PAINT_MOST_N, brought
from frictionloop.studio.parameter_panels import system_message
from frictionloop.studio.room import Room
from frictionloop.studio.server import studio_app

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # starlette would have another client than httpx
    from starlette.testclient import TestClient

ASKED = {"mm_per_pixel": "0.5", "polarity": "dark", "low_n": "0.2", "high_n": "0.8"}
WAV = {"over": "place", "speed_mm_s": "40", "scale_n": "0.5", "offset_n": "0.45"}


def test_a_picture_becomes_a_map_with_the_scale_and_the_polarity_that_were_given():
    made = brought("png", png([[0, 255, 255], [255, 255, 0]]), ASKED).effect
    assert isinstance(made, Map)
    assert made.pitch_mm == 0.5
    np.testing.assert_allclose(made.table, [[0.2, 0.2, 0.8], [0.8, 0.2, 0.2]])


def test_colours_are_turned_to_grey_and_it_is_said():
    coloured = np.zeros((4, 5, 4))
    coloured[..., :3], coloured[:, 3:, 3] = 255, 255  # the left is transparent: white
    made = brought("png", png(coloured), ASKED | {"polarity": "bright"})
    np.testing.assert_allclose(made.effect.table, 0.8)
    assert "in grey" in made.told


def test_a_recording_is_played_by_place_around_its_mean():
    tone = 16384 * np.sin(2 * np.pi * 80 * np.arange(8000) / 8000)
    made = brought("wav", wav(tone), WAV).effect
    force = np.array(made.values_n[0])
    assert made.beyond == "repeat"
    assert force.mean() == pytest.approx(0.45, abs=1e-3)
    assert force[100:-100].std() == pytest.approx(0.25 / np.sqrt(2), rel=0.01)
    assert force.size * made.pitch_mm == pytest.approx(40.0, rel=0.01)


def test_a_recording_over_time_keeps_its_pitch_and_needs_no_speed():
    tone = 16384 * np.sin(2 * np.pi * 80 * np.arange(8000) / 8000)
    made = brought("wav", wav(tone), {"over": "time", "scale_n": "0.5", "offset_n": "0.45"}).effect
    assert (made.kind, made.loops, made.duration_s) == ("wave", True, pytest.approx(1.0, abs=0.01))
    time_s = np.arange(200, 800) / 1000
    force = np.array([made.force_n(fl.rendering.Touch(time_s=each, x_mm=5.0)) for each in time_s])
    np.testing.assert_allclose(force, 0.45 + 0.25 * np.sin(2 * np.pi * 80 * time_s), atol=5e-3)


def test_paint_is_a_map_in_steps_of_a_byte():
    made = brought("paint", bytes([0, 255, 128, 0, 0, 51]), {"columns": "3", "rows": "2"}).effect
    assert made.pitch_mm == PAINT_MM
    np.testing.assert_allclose(made.table, PAINT_MOST_N / 255 * np.array([[0, 255, 128], [0, 0, 51]]), atol=1e-4)
    assert made.start_mm == -PAINT_MM


def post(at, room, content, key=None, **asked):
    query = {"kind": "paint", "columns": "4", "rows": "3"} | asked
    headers = {"x-studio-page": room.driver.key if key is None else key}
    return at.post("/effect", params=query, content=content, headers=headers)


def test_only_the_driving_page_lays_an_effect_on_the_plate():
    room = Room(Session(Echo()))
    with TestClient(studio_app(room), base_url="http://localhost") as at:
        assert "another page drives" in at.post("/effect?kind=paint", content=b"").json()["why"]
        room.join(Guest(True))
        room.join(other := Guest(True))
        assert "another page drives" in post(at, room, bytes(12), key=other.key).json()["why"]
        answer = post(at, room, bytes([200] * 12))
        assert answer.status_code == 200
        assert answer.json()["told"].startswith("map (")
        assert room.session.engine.system.setpoint.effect.kind == "map"
        assert room.before[-1] == GRATING
        long = post(at, room, bytes(MOST_BYTES + 1))
        assert long.status_code == 400
        assert "must be smaller" in long.json()["why"]


def test_a_page_from_elsewhere_or_without_the_token_brings_nothing():
    with TestClient(studio_app(Room(Session(Echo()))), base_url="http://localhost") as at:
        assert at.post("/effect?kind=paint", headers={"origin": "http://evil.example"}).status_code == 403
    with TestClient(studio_app(Room(Session(Echo())), Doors((), "drive", "watch")), base_url="http://localhost") as at:
        assert at.post("/effect?kind=paint").status_code == 403
        assert at.post("/effect?kind=paint&token=watch").status_code == 403


def test_what_is_told_of_a_loop_with_a_painting_stays_short():
    made = brought("paint", bytes(range(250)) * 100, {"columns": "250", "rows": "100"}).effect
    told = system_message(fl.bench().evolve({"setpoint": {"kind": "effect", "effect": made}}))
    assert told["differs"] is None
    assert 'read_toml("system.toml")' in told["python"]
    assert told["command"] == "frictionloop studio system.toml"
    assert len(str(told)) < 100_000
