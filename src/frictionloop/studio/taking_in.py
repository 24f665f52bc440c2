"""The door for effects that a page brings along: who may, how much, one at a time, read beside the session."""

from __future__ import annotations

import asyncio

from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response

from frictionloop.quantities import FrictionloopError
from frictionloop.studio import background
from frictionloop.studio.changes import change
from frictionloop.studio.room import Room
from frictionloop.studio.safe import HEADERS

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
