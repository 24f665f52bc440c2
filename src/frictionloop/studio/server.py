"""The web application: one page, its files, one socket, and what a page brings: a bench, runs, effects."""

from __future__ import annotations

import asyncio
import json
import tempfile
import warnings
from collections.abc import AsyncIterator, Awaitable, Callable, Collection
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from frictionloop.live.live_engines import CHANNELS
from frictionloop.live.live_session import recorded
from frictionloop.loop.record import save
from frictionloop.parameters import System, preset
from frictionloop.parameters.toml_reader import read_tree
from frictionloop.parameters.toml_writer import to_toml
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.rendering.effect_setpoint import EffectSource
from frictionloop.studio import background
from frictionloop.studio.commands import PRESETS, change, check_no_file, obey
from frictionloop.studio.connections import HEADERS, Doors, Guest, as_file, file_answer, refused, talk
from frictionloop.studio.effect_pictures import HEIGHT_MM, PAINT_MM, PAINT_MOST_N, gallery
from frictionloop.studio.parameter_panels import system_message
from frictionloop.studio.replay import read_run
from frictionloop.studio.room import Room

STATIC = Path(__file__).parent / "static"
FILES = {path.relative_to(STATIC).as_posix(): path for path in sorted(STATIC.rglob("*")) if path.is_file()}
"""What is served, by its name: nothing else of the disk is."""
SAVED = {"run.h5": "application/x-hdf5", "run.csv": "text/csv"}
MOST_TEXT = 20_000
"""Characters of a command (assumed: a whole System is 5000)."""
PAGE = "x-studio-page"
"""Header that tells which page asks; no page from elsewhere can send it, for browsers ask us first."""
MOST_BYTES = {"toml": 256 * 1024, "h5": 64 * 1024 * 1024}
"""Length of a file by its kind: of a run a minute of every signal at 5 kHz (assumed)."""
LONGEST_NAME = 80
Answer = Callable[[Request], Awaitable[Response]]


def studio_app(room: Room, doors: Doors | None = None) -> Starlette:
    """Return the application that serves a room."""
    doors = doors or Doors()

    def gated(answer: Answer, roles: Collection[str] = ("drive", "watch")) -> Answer:
        async def checked(request: Request) -> Response:
            return await answer(request) if doors.role(request) in roles else refused()

        return checked

    def page(name: str) -> Answer:
        async def answer(request: Request) -> Response:
            return file_answer(FILES, name)

        return gated(answer)

    async def runs(request: Request) -> Response:
        return runs_answer(room)

    async def file(request: Request) -> Response:
        # Files hold nothing of the session, and modules import one another without a token.
        return file_answer(FILES, request.path_params["name"])

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
        await asyncio.to_thread(background.load)
        return save_answer(room, request.path_params["name"])

    routes = [
        Route("/", page("index.html")),
        Route("/replay", page("replay.html")),
        Route("/runs.json", gated(runs)),
        Route("/open", gated(taking(room, "file", file_in), ["drive"]), methods=["POST"]),
        Route("/effect", gated(taking(room, "effect", effect_in), ["drive"]), methods=["POST"]),
        Route("/save/{name}", gated(saved)),
        Route("/static/{name:path}", file),
        WebSocketRoute("/live", socket),
    ]
    return Starlette(routes=routes, lifespan=lifespan)


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


def taking(room: Room, what: str, take: Callable[[Room, Request], Awaitable[dict[str, Any]]]) -> Answer:
    """Return what answers the driving page that brings something; one is read at a time, beside the session."""
    reading = asyncio.Lock()

    async def answer(request: Request) -> Response:
        try:
            _check_driver(room, request, what)
            if reading.locked():
                raise FrictionloopError(f"{what}: another is being read")
            async with reading:
                return JSONResponse(await take(room, request), headers=HEADERS)
        except ClientDisconnect:
            why = f"{what}: the page has gone"
        except FrictionloopError as error:
            why = str(error)
        return JSONResponse({"why": why}, 400, headers=HEADERS)

    return answer


def _check_driver(room: Room, request: Request, what: str) -> None:
    if room.driver is None or request.headers.get(PAGE, "") != room.driver.key:
        raise FrictionloopError(f"{what}: another page drives")
    if what == "effect" and (kind := room.session.engine.system.setpoint.kind) != "effect":
        raise must_be("setpoint.kind", kind, "effect")


async def effect_in(room: Room, request: Request) -> dict[str, Any]:
    """Put the effect of a request in force, and return what was made of it."""
    await asyncio.to_thread(background.load)
    from frictionloop.studio.effect_uploads import MOST_BYTES, brought

    content, asked = await content_of(request, MOST_BYTES), dict(request.query_params)
    made = await asyncio.to_thread(brought, asked.get("kind", ""), content, asked)
    _check_driver(room, request, "effect")
    _put(room, lambda system: system.evolve({"setpoint.effect": made.effect}))
    return {"told": made.told}


async def file_in(room: Room, request: Request) -> dict[str, Any]:
    """Put the bench of a request in force, or keep its run to be played."""
    name = request.query_params.get("name", "")[:LONGEST_NAME]
    kind = name.rpartition(".")[2].lower()
    if kind not in MOST_BYTES:
        raise must_be("file", name, ".toml or .h5")
    content = await content_of(request, MOST_BYTES[kind])
    if kind == "h5":
        room.runs.appendleft(await asyncio.to_thread(run_in, content, name))
        return {"told": f"{name} can be played", "go": "/replay"}
    system = await asyncio.to_thread(system_in, content, name)
    _check_driver(room, request, "file")
    _put(room, lambda _: system)
    return {"told": f"{name} is in force"}


def _put(room: Room, make: Callable[[System], System]) -> None:
    change(room, make)
    room.tell_status()


async def content_of(request: Request, most: int) -> bytes:
    """Return the body of a request, and refuse it as soon as it has more than so many bytes."""
    parts, size = [], 0
    async for part in request.stream():
        parts.append(part)
        if (size := size + len(part)) > most:
            raise must_be("file", f"over {most} bytes", "smaller")
    return b"".join(parts)


def system_in(content: bytes, name: str) -> System:
    """Return the System that a TOML text describes; it may name no file, for a page does not reach the file system."""
    with as_file(content, "bench.toml", name) as path:
        tree = read_tree(path)
        base = tree.pop("preset", None)
        check_no_file(tree)
        system = System.from_tree(tree, f"{name}: ") if base is None else preset(base).evolve(tree)
    return system if isinstance(system.setpoint, EffectSource) else system.evolve(setpoint={"kind": "effect"})


def run_in(content: bytes, name: str) -> dict[str, Any]:
    """Return what a page plays of a recorded run; a file that expands out of measure is refused."""
    with as_file(content, "run.h5", name) as path, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a recording that was not finished: the page plays what there is
        return read_run(path, name)


def runs_answer(room: Room) -> Response:
    """Return the runs that a page can play."""
    if not room.runs:
        why = "no run is open"
        return Response(why, 404, headers=HEADERS, media_type="text/plain")
    content = json.dumps(list(room.runs), allow_nan=False)
    return Response(content, headers=HEADERS, media_type="application/json")
