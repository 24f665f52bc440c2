"""Files that a page brings: a bench as TOML, which is put in force, runs, which are played, and effects."""

from __future__ import annotations

import asyncio
import json
import warnings
from collections.abc import Awaitable, Callable
from typing import Any

from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response

from frictionloop.parameters import System, preset
from frictionloop.parameters.toml_files import read_tree
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.rendering.effect_source import EffectSource
from frictionloop.studio import background
from frictionloop.studio.commands import change, check_no_file
from frictionloop.studio.connections import HEADERS, as_file
from frictionloop.studio.replay import read_run
from frictionloop.studio.room import Room

PAGE = "x-studio-page"
"""Header that tells which page asks; no page from elsewhere can send it, for browsers ask us first."""
MOST_BYTES = {"toml": 256 * 1024, "h5": 64 * 1024 * 1024}
"""Length of a file by its kind: of a run a minute of every signal at 5 kHz (assumed)."""
LONGEST_NAME = 80
Answer = Callable[[Request], Awaitable[Response]]


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
    from frictionloop.studio.uploads import MOST_BYTES, brought

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
