"""Files that a page brings: a bench as TOML, which is put in force, runs, which are played, and effects."""

from __future__ import annotations

import asyncio
import json
import tempfile
import warnings
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response

from frictionloop.parameters import System, preset
from frictionloop.parameters.files import read_tree
from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.source import EffectSource
from frictionloop.studio import background
from frictionloop.studio.commands import change, check_no_file
from frictionloop.studio.connections import HEADERS, Guest
from frictionloop.studio.replay import read_run
from frictionloop.studio.room import Room

PAGE = "x-studio-page"
"""Header that tells which page asks; no page from elsewhere can send it, for browsers ask us first."""


async def taken_in(room: Room, request: Request, reading: asyncio.Lock) -> Response:
    """Put the effect of a request in force, and answer what was made of it, or why not."""
    try:
        _check(room, request)
        if reading.locked():
            raise FrictionloopError("effect: another one is being read")
        async with reading:
            await asyncio.to_thread(background.load)
            from frictionloop.studio.uploads import MOST_BYTES, brought

            content = await content_of(request, MOST_BYTES)
            asked = dict(request.query_params)
            made = await asyncio.to_thread(brought, asked.get("kind", ""), content, asked)
        _check(room, request)
        change(room, lambda system: system.evolve({"setpoint.effect": made.effect}))
        room.tell_status()
    except ClientDisconnect:
        return JSONResponse({"why": "effect: the page has gone"}, 400, headers=HEADERS)
    except FrictionloopError as error:
        return JSONResponse({"why": str(error)}, 400, headers=HEADERS)
    return JSONResponse({"told": made.told}, headers=HEADERS)


def _check(room: Room, request: Request) -> None:
    key = request.headers.get(PAGE, "")
    if room.driver is None or key != room.driver.key:
        raise FrictionloopError("effect: another page drives")
    if room.session.engine.system.setpoint.kind != "effect":
        raise FrictionloopError("setpoint.kind: must be effect")


async def content_of(request: Request, most: int) -> bytes:
    """Return the body of a request, and refuse it as soon as it has more than so many bytes."""
    parts, size = [], 0
    async for part in request.stream():
        parts.append(part)
        if (size := size + len(part)) > most:
            raise FrictionloopError(f"file: over {most} bytes; must be smaller")
    return b"".join(parts)


MOST_BYTES = {"toml": 256 * 1024, "h5": 64 * 1024 * 1024}
"""Length of a file by its kind: of a run a minute of every signal at 5 kHz (assumed)."""
LONGEST_NAME = 80
Answer = Callable[[Request], Awaitable[Response]]


def opener(room: Room, may_drive: Callable[[Request], bool], refused: Callable[[], Response]) -> Answer:
    """Return what answers a page that opens a file; one is read at a time, beside the session."""
    reading = asyncio.Lock()

    async def open_file(request: Request) -> Response:
        if not may_drive(request):
            return refused()
        try:
            guest = _driver(room, request)
            if reading.locked():
                raise FrictionloopError("file: another one is being read")
            async with reading:
                return JSONResponse(await _opened(room, guest, request), headers=HEADERS)
        except FrictionloopError as error:
            return JSONResponse({"why": str(error)}, 400, headers=HEADERS)

    return open_file


def runs_answer(room: Room) -> Response:
    """Return the runs that a page can play."""
    if not room.runs:
        why = "no run is open"
        return Response(why, 404, headers=HEADERS, media_type="text/plain")
    content = json.dumps(list(room.runs), allow_nan=False)
    return Response(content, headers=HEADERS, media_type="application/json")


def system_in(content: bytes, name: str) -> System:
    """Return the System that a TOML text describes; it may name no file, for a page does not reach the file system."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bench.toml"
        path.write_bytes(content)
        try:
            tree = read_tree(path)
            base = tree.pop("preset", None)
            check_no_file(tree)
            system = System.from_tree(tree, f"{name}: ") if base is None else preset(base).evolve(tree)
        except FrictionloopError as error:
            raise FrictionloopError(str(error).replace(str(path), name)) from None
    return system if isinstance(system.setpoint, EffectSource) else system.evolve(setpoint={"kind": "effect"})


def run_in(content: bytes, name: str) -> dict[str, Any]:
    """Return what a page plays of a recorded run; a file that expands out of measure is refused."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a recording that was not finished: the page plays what there is
        path = Path(folder) / "run.h5"
        path.write_bytes(content)
        try:
            return read_run(path, name)
        except FrictionloopError as error:
            raise FrictionloopError(str(error).replace(str(path), name)) from None


def _driver(room: Room, request: Request) -> Guest:
    if room.driver is None or request.headers.get(PAGE, "") != room.driver.key:
        raise FrictionloopError("file: another page drives")
    return room.driver


async def _opened(room: Room, guest: Guest, request: Request) -> dict[str, Any]:
    name = request.query_params.get("name", "")[:LONGEST_NAME]
    kind = name.rpartition(".")[2].lower()
    if kind not in MOST_BYTES:
        raise FrictionloopError(f"{name}: must be .toml or .h5")
    content = await content_of(request, MOST_BYTES[kind])
    if kind == "h5":
        room.runs.appendleft(await asyncio.to_thread(run_in, content, name))
        return {"told": f"{name} can be played", "go": "/replay"}
    system = await asyncio.to_thread(system_in, content, name)
    if guest is not room.driver:
        raise FrictionloopError("file: another page drives")
    change(room, lambda _: system)
    room.tell_status()
    return {"told": f"{name} is in force"}
