"""What tests do with a page of the studio."""

from __future__ import annotations

import time

from live_engines import Echo

from frictionloop.live.live_session import Session
from frictionloop.studio.room import Room


def until(what, timeout_s=120.0):
    """Wait until something is true, which a busy machine is late with, and return it."""
    end = time.monotonic() + timeout_s
    while not (value := what()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)
    return value


def room_of(engine=None, ghost=False):
    """Return a room whose second loop is shown only when asked for."""
    room = Room(Session(engine or Echo()))
    room.session.ghost_on = ghost
    return room


def seen(page, expression):
    """Wait until an expression is true in the page, whose policy forbids Playwright's own way."""
    until(lambda: page.evaluate(expression))


def opened(page, url):
    """Open a studio and wait until the page knows what it shows."""
    page.goto(url)
    seen(page, "document.querySelector('#source').textContent !== 'connecting'")
