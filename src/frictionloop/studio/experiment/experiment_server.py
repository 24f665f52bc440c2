"""The two pages of an experiment, served from a thread: roles by token, a socket each, clocks told."""

from __future__ import annotations

import asyncio
import secrets
import threading
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.optional_libraries import needed
from frictionloop.studio.connections import HEADERS, LOOPBACK, Doors, Guest, file_answer, listening, refused, talk
from frictionloop.studio.experiment.page_messages import EXPERIMENTER, PARTICIPANT
from frictionloop.studio.experiment.page_respondent import Desk

STATIC = Path(__file__).parent / "static"
SHARED = Path(__file__).parent.parent / "static"
FILES = {each.name: each for each in STATIC.iterdir() if each.is_file()} | {
    name: SHARED / name for name in ("studio.css", "icon.svg")
}
"""What is served, by its name: nothing else of the disk is."""
MOST_TEXT = 2000
"""Characters of a message (assumed: a note has 500)."""
ROLES = {"drive": (EXPERIMENTER, PARTICIPANT), "watch": (PARTICIPANT,)}
"""Which pages a token opens."""


def experiment_app(desk: Desk, doors: Doors) -> Starlette:
    """Return the application that serves an experiment."""

    def allowed(request: Any, role: str) -> bool:
        return role in ROLES.get(doors.role(request), ())

    async def page(request: Request) -> Response:
        role = request.path_params["role"]
        if role not in (PARTICIPANT, EXPERIMENTER):
            return PlainTextResponse("there are /participant and /experimenter", 404, headers=HEADERS)
        if not allowed(request, role):
            return refused()
        return file_answer(FILES, f"{role}.html")

    async def file(request: Request) -> Response:
        return file_answer(FILES, request.path_params["name"])

    async def socket(socket: WebSocket) -> None:
        role = socket.path_params["role"]
        if not allowed(socket, role):
            await socket.close(1008)
            return
        await socket.accept()
        await _serve(desk, role, socket)

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        desk.hub.loop = asyncio.get_running_loop()
        yield

    routes = [
        Route("/static/{name}", file),
        WebSocketRoute("/live/{role}", socket),
        Route("/{role}", page),
    ]
    return Starlette(routes=routes, lifespan=lifespan)


async def _serve(desk: Desk, role: str, socket: WebSocket) -> None:
    guest = Guest(role == EXPERIMENTER)
    desk.hub.join(role, guest)
    desk.heard.connected()

    def hear(message: Any) -> None:
        if not isinstance(message, dict):
            raise FrictionloopError("message: must be an object")
        if message.get("do") == "clock":
            guest.put({"type": "clock", "sent": message.get("sent"), "host_s": time.monotonic()})
            return
        desk.heard.hear(role, message)

    try:
        await talk(socket, guest, hear, MOST_TEXT)
    finally:
        desk.hub.leave(role, guest)
        desk.heard.connected()


LAST_S = 1.0
"""Time in which pages still hear that a session is over (assumed)."""


class Addresses(NamedTuple):
    """Where the pages are; each address holds its token."""

    participant: str
    experimenter: str


@contextmanager
def served(desk: Desk, host: str = "127.0.0.1", port: int = 0) -> Iterator[Addresses]:
    """Serve the pages of a session, and yield their addresses."""
    uvicorn = needed("uvicorn", "uvicorn", "studio")
    needed("starlette", "starlette", "studio")

    # The participant's token must not open the experimenter's page, also on one machine.
    doors = Doors(LOOPBACK if host in LOOPBACK else (), secrets.token_urlsafe(16), secrets.token_urlsafe(16))
    bound = listening(host, port)
    config = uvicorn.Config(
        experiment_app(desk, doors), log_level="error", ws="websockets-sansio", timeout_graceful_shutdown=1
    )
    config.ws_max_size = 64 * 1024
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [bound]}, daemon=True)
    thread.start()
    root = f"http://{host}:{bound.getsockname()[1]}"
    try:
        while not server.started and thread.is_alive():
            time.sleep(0.01)
        yield Addresses(f"{root}/participant?token={doors.watch_token}", f"{root}/experimenter?token={doors.token}")
        time.sleep(LAST_S)
    finally:
        server.should_exit = True
        thread.join(5)
        bound.close()
