"""The web application: one page, its files, one socket."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from frictionloop.live.engines import CHANNELS
from frictionloop.live.session import recorded
from frictionloop.loop.record import save
from frictionloop.parameters import System
from frictionloop.parameters.written import to_toml
from frictionloop.studio import background
from frictionloop.studio.commands import PRESETS, obey
from frictionloop.studio.connections import HEADERS, Doors, Guest, file_answer, talk
from frictionloop.studio.effect_pictures import HEIGHT_MM, PAINT_MM, PAINT_MOST_N, gallery
from frictionloop.studio.page_files import Answer, effect_in, file_in, runs_answer, taking
from frictionloop.studio.panels import system_message
from frictionloop.studio.room import Room

STATIC = Path(__file__).parent / "static"
FILES = {path.relative_to(STATIC).as_posix(): path for path in sorted(STATIC.rglob("*")) if path.is_file()}
"""What is served, by its name: nothing else of the disk is."""
SAVED = {"run.h5": "application/x-hdf5", "run.csv": "text/csv"}
MOST_TEXT = 20_000
"""Characters of a command (assumed: a whole System is 5000)."""


def studio_app(room: Room, doors: Doors | None = None) -> Starlette:
    """Return the application that serves a room."""
    doors = doors or Doors()

    def page(name: str) -> Answer:
        async def answer(request: Request) -> Response:
            if not doors.role(request):
                return refused()
            return file_answer(FILES[name])

        return answer

    async def runs(request: Request) -> Response:
        return runs_answer(room) if doors.role(request) else refused()

    async def file(request: Request) -> Response:
        # Files hold nothing of the session, and modules import one another without a token.
        name = request.path_params["name"]
        if name not in FILES:
            return PlainTextResponse("no such file", 404, headers=HEADERS)
        return file_answer(FILES[name])

    async def socket(socket: WebSocket) -> None:
        if not (role := doors.role(socket)):
            await socket.close(1008)
            return
        await socket.accept()
        await _serve(room, Guest(role == "drive"), socket)

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        task = asyncio.create_task(room.run())
        pictures = asyncio.create_task(asyncio.to_thread(gallery))
        background.started()
        yield
        await pictures
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task

    async def saved(request: Request) -> Response:
        if not doors.role(request):
            return refused()
        await asyncio.to_thread(background.load)
        return save_answer(room, request.path_params["name"])

    def driving(answer: Answer) -> Answer:
        async def gated(request: Request) -> Response:
            return await answer(request) if doors.role(request) == "drive" else refused()

        return gated

    routes = [
        Route("/", page("index.html")),
        Route("/replay", page("replay.html")),
        Route("/runs.json", runs),
        Route("/open", driving(taking(room, "file", file_in)), methods=["POST"]),
        Route("/effect", driving(taking(room, "effect", effect_in)), methods=["POST"]),
        Route("/save/{name}", saved),
        Route("/static/{name:path}", file),
        WebSocketRoute("/live", socket),
    ]
    return Starlette(routes=routes, lifespan=lifespan)


def refused() -> Response:
    """Return the answer to who may not come in."""
    return PlainTextResponse(
        "Use the address that was printed.",
        403,
        headers=HEADERS,
    )


def save_answer(room: Room, name: str) -> Response:
    """Return the last 30 s, or the System, as a file to download."""
    if name == "system.toml":
        return PlainTextResponse(to_toml(room.session.engine.system), headers=HEADERS)
    if name not in SAVED:
        return PlainTextResponse(f"no such file; there are {', '.join(SAVED)} and system.toml", 404, headers=HEADERS)
    if not room.session.ticks:
        return PlainTextResponse("nothing has run yet", 409, headers=HEADERS)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        save(recorded(room.session), path)
        content = path.read_bytes()
    return Response(content, media_type=SAVED[name], headers=HEADERS)


def hello_message(system: System, page: str) -> dict[str, Any]:
    """Return what a page is told first: what there is to be seen and chosen."""
    return {
        "type": "hello",
        "channels": {name: list(told) for name, told in CHANNELS.items()},
        "effects": gallery(),
        "plate_mm": [system.touch.load.length_mm, HEIGHT_MM],
        "presets": [{"name": each.name, "told": each.told} for each in PRESETS],
        "page": page,
        "paint": {"mm": PAINT_MM, "most_n": PAINT_MOST_N},
    }


async def _serve(room: Room, guest: Guest, socket: WebSocket) -> None:
    drawn = await room.drawing.drawn()
    system = room.session.engine.system
    guest.put(hello_message(system, guest.key))
    guest.put(system_message(system))
    guest.put(drawn)
    room.join(guest)

    def hear(told: Any) -> None:
        room.heard(guest)
        if isinstance(told, bytes):
            room.touched(guest, told)
        else:
            obey(room, guest, told)

    try:
        await talk(socket, guest, hear, MOST_TEXT)
    finally:
        room.leave(guest)
