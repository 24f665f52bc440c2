"""Twelve fingers under one stroke: the same stroke for all, each as the loop of its own would have it."""

from __future__ import annotations

import numpy as np
import pytest
from live_engines import GRATING, Echo
from studio_pages import opened, until

import frictionloop as fl
from frictionloop.live.live_engines import CHANNELS, CROWD, Crowd, TwinEngine
from frictionloop.live.live_session import Session
from frictionloop.studio.parallel_fingers import PEOPLE
from frictionloop.studio.room import Room

pytestmark = pytest.mark.slow
PERSON = {"friction.nominal_n": 1.3, "motion.tremor_um": 0.0}


def test_everybody_feels_the_stroke_of_the_session_as_if_alone():
    """To 30 mN rms: the crowd gets the place in float32, and each loop is as sensitive as a loop is."""
    people = [PERSON, PERSON | {"friction.nominal_n": 0.8}]
    live = Session(TwinEngine(GRATING.evolve(PERSON)))
    crowd = Crowd(GRATING, people)
    live.step(0.0)
    blocks = [block for k in range(30) for block in live.step(0.1 * (k + 1))]
    told = dict(zip(CROWD, np.concatenate([crowd.advance(block.rows) for block in blocks], axis=1), strict=True))
    own = dict(zip(CHANNELS, np.concatenate([block.rows for block in blocks], axis=1), strict=True))
    for name in ("asked_n", "open_n", "closed_n"):
        apart = told[name][5000:, 0] - own[name][5000:]
        assert np.sqrt(np.mean(apart**2)) < 0.03, name
    assert np.abs(told["open_n"][5000:, 1] - own["open_n"][5000:]).mean() > 0.1


def test_a_change_reaches_everybody_and_leaves_who_they_are():
    crowd, rows = Crowd(GRATING, [PERSON, {"friction.nominal_n": 0.8}]), np.zeros((len(CHANNELS), 500))
    rows[0], rows[1] = np.linspace(0.0, 4.0, 500), 0.5
    crowd.advance(rows)
    crowd.change(GRATING.evolve({"setpoint.effect": fl.rendering.Constant(level_n=0.4), "friction.nominal_n": 1.0}))
    rows[0] += 4.0
    told = dict(zip(CROWD, crowd.advance(rows), strict=True))
    np.testing.assert_allclose(told["asked_n"], 0.4, rtol=1e-6)
    assert told["open_n"][-100:, 0].mean() > 1.2 * told["open_n"][-100:, 1].mean()


def test_what_a_device_does_not_know_of_its_finger_is_a_finger_in_the_air():
    crowd, rows = Crowd(GRATING, [PERSON]), np.full((len(CHANNELS), 500), np.nan)
    told = dict(zip(CROWD, crowd.advance(rows), strict=True))
    assert told["open_n"].shape == (500, 1)
    assert np.isfinite(told["open_n"]).all()
    assert np.abs(told["open_n"]).max() < 1e-6


def test_the_row_of_fingers_is_shown_and_one_of_them_is_taken(page, serve):
    room = Room(Session(TwinEngine(GRATING)))
    opened(page, serve(room).url)
    page.click("#crowd-on")
    until(lambda: page.text_content("#crowd-told").startswith("Error with the loop open"))
    assert page.locator("#people button").count() == PEOPLE
    assert "mN open" in page.get_attribute("#people button:first-child", "aria-label")
    page.click("#people button:nth-child(4)")
    wanted = fl.fingers(4, 0)[3]["friction.nominal_n"]
    until(lambda: room.session.engine.system.friction.nominal_n == pytest.approx(wanted))
    page.click("#finger")
    wanted = fl.fingers(5, 0)[4]["friction.nominal_n"]
    until(lambda: room.session.engine.system.friction.nominal_n == pytest.approx(wanted))
    page.click("#crowd-on")
    until(lambda: not any(guest.crowd for guest in room.guests))
    assert page.is_hidden("#people")


def test_a_loop_that_the_population_does_not_fit_is_told(page, serve):
    room = Room(Session(Echo()))
    room.session.engine.system = GRATING.evolve({"friction.kind": "gaussian"})
    opened(page, serve(room).url)
    page.click("#crowd-on")
    until(lambda: "cannot be shown" in page.text_content("#crowd-told"))
