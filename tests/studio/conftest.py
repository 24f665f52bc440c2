"""A studio that runs, and a browser to look at it with."""

from __future__ import annotations

import shutil
import socket
import threading
import time

import pytest


class Served:
    """A studio on a free port, in a thread of its own."""

    def __init__(self, room, doors=None, port=0):
        import uvicorn

        from frictionloop.studio.server import studio_app

        self.room = room
        self.socket = socket.socket()
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.bind(("127.0.0.1", port))
        self.port = self.socket.getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}/"
        app = studio_app(room, doors)
        config = uvicorn.Config(app, log_level="error", ws="websockets-sansio", timeout_graceful_shutdown=1)
        self.server = uvicorn.Server(config)
        self.thread = threading.Thread(target=self.server.run, kwargs={"sockets": [self.socket]}, daemon=True)
        self.thread.start()
        while not self.server.started:
            time.sleep(0.01)

    def stop(self):
        self.server.should_exit = True
        self.thread.join(10)
        self.socket.close()


@pytest.fixture
def serve():
    made = []

    def start(room, doors=None, port=0):
        made.append(Served(room, doors, port))
        return made[-1]

    yield start
    for each in made:
        each.stop()


@pytest.fixture(scope="session")
def browser():
    path = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if path is None:
        pytest.skip("no chromium on the PATH (apt-get install chromium)")
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with playwright.sync_playwright() as started:
        found = started.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield found
        found.close()


@pytest.fixture
def page(browser, serve):
    """Return a page that has said nothing wrong when the test ends, but for lines in its ``excused``.

    It closes before its server stops, which it would otherwise miss.
    """
    context = browser.new_context(viewport={"width": 1280, "height": 900}, accept_downloads=True)
    context.set_default_timeout(120_000)
    opened, wrong = context.new_page(), []
    opened.excused = ()
    opened.on("console", lambda message: message.type == "error" and wrong.append(message.text))
    opened.on("pageerror", lambda error: wrong.append(str(error)))
    yield opened
    context.close()
    assert [each for each in wrong if not any(part in each for part in opened.excused)] == []
