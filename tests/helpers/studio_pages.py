"""What tests do with a page of the studio."""

from __future__ import annotations

import time


def until(what, timeout_s=10.0):
    """Wait until something is true, and return it."""
    end = time.monotonic() + timeout_s
    while not (value := what()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)
    return value


def seen(page, expression, timeout_s=10.0):
    """Wait until an expression is true in the page, whose policy forbids Playwright's own way."""
    until(lambda: page.evaluate(expression), timeout_s)


def opened(page, url):
    """Open a studio and wait until the page drives."""
    page.goto(url)
    seen(page, "document.querySelector('#status').textContent.includes('drives')")
