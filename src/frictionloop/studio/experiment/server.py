"""The two pages of an experiment: roles by token, a socket each, clocks told."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from frictionloop.quantities import FrictionloopError
from frictionloop.studio.experiment.desk import Desk
from frictionloop.studio.experiment.hub import EXPERIMENTER, PARTICIPANT
from frictionloop.studio.filing import file_answer
from frictionloop.studio.guest import Guest
from frictionloop.studio.safe import HEADERS, Doors
from frictionloop.studio.talking import talk

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
    """Return the application that serves an experiment.

    Parameters
    ----------
    desk : Desk
        The session.
    doors : Doors
        Who may come in: ``token`` opens the experimenter's page, ``watch_token`` the participant's alone.
    """

    def allowed(request: Any, role: str) -> bool:
        return role in ROLES.get(doors.role(request), ())

    async def page(request: Request) -> Response:
        role = request.path_params["role"]
        if role not in (PARTICIPANT, EXPERIMENTER):
            return PlainTextResponse("there are /participant and /experimenter", 404, headers=HEADERS)
        if not allowed(request, role):
            return PlainTextResponse("Use the address that was printed.", 403, headers=HEADERS)
        return file_answer(FILES[f"{role}.html"])

    async def file(request: Request) -> Response:
        if (name := request.path_params["name"]) not in FILES:
            return PlainTextResponse("no such file", 404, headers=HEADERS)
        return file_answer(FILES[name])

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
