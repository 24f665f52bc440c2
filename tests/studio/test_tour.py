"""The tour as a new user takes it: every step asks for one thing, and says so when it has been done."""

from __future__ import annotations

import pytest
from live_engines import GRATING
from studio_pages import opened, seen, until

from frictionloop.live.live_engines import TwinEngine
from frictionloop.live.live_session import Session
from frictionloop.studio.room import Room

pytestmark = pytest.mark.slow


def slide(page):
    box = page.locator("#plate").bounding_box()
    page.mouse.move(box["x"] + 150, box["y"] + 80)
    page.mouse.down()
    for step in range(40):
        page.mouse.move(box["x"] + 150 + 6 * step, box["y"] + 80)
        page.wait_for_timeout(16)
    page.mouse.up()


def three_fingers(page):
    for _ in range(3):
        page.click("#finger")


def gains_that_hold(page):
    page.click("#presets-open")
    page.click("#presets >> text=Gains that hold")


def typed(path, value):
    def fill(page):
        field = page.locator(f".field:has([title='{path}']) input[type=number]")
        field.fill(value)
        field.press("Enter")

    return fill


def take(page):
    page.click("#people button:first-child")


def test_every_step_is_done_by_what_it_asks_for(page, serve):
    room = Room(Session(TwinEngine(GRATING)))
    opened(page, serve(room).url)
    page.click("#tour")
    steps = (
        slide,
        three_fingers,
        slide,
        gains_that_hold,
        typed("controller.delay_s", "0.0015"),
        typed("plate.max_amplitude_um", "2.5"),
        take,
    )
    for number, step in enumerate(steps):
        until(lambda number=number: page.text_content("#tour-card .count") == f"{number + 1} of 7")
        page.wait_for_timeout(400)
        assert page.text_content("#tour-card .done") == "", number
        step(page)
        seen(page, "document.querySelector('#tour-card .done').textContent.startsWith('✓')")
        page.click("[data-tour=next]")
    assert page.is_hidden("#tour-card")
    until(lambda: room.session.engine.system == GRATING)  # as it was before the tour
    assert page.is_hidden("#people")


def test_what_the_steps_say_is_so(page, serve):
    """The paper's gains run from limit to limit, gains that hold do not; delay makes gains swing that were calm."""
    room = Room(Session(TwinEngine(GRATING)))
    opened(page, serve(room).url)
    page.click("#tour")
    for _ in range(3):
        page.click("[data-tour=next]")
    until(lambda: "gain is too high" in page.text_content("#verdict"))
    gains_that_hold(page)
    until(lambda: page.text_content("[data-number=saturated]") in ("0 %", "1 %"))
    page.click("[data-tour=next]")

    def error_mn():
        return float(page.text_content("[data-number=closed_error_n]").removesuffix(" mN").replace("–", "nan"))

    until(lambda: error_mn() < 60.0)
    typed("controller.delay_s", "0.002")(page)
    until(lambda: error_mn() > 120.0)
