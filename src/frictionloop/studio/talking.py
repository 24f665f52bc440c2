"""A page at its socket: what waits for it is sent, and what it says is heard, until it goes."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from frictionloop.quantities import FrictionloopError
from frictionloop.studio.guest import Guest


async def talk(socket: WebSocket, guest: Guest, hear: Callable[[Any], None], most: int) -> None:
    """Talk to a page until it goes; what it is refused is told to it in words.

    Parameters
    ----------
    socket : WebSocket
        Accepted already.
    guest : Guest
        The page, with what waits for it.
    hear : callable
        Takes what it says: bytes as they are, and a text as the JSON that it holds.
    most : int
        Characters of a text at most.
    """
    sending = asyncio.create_task(_send(guest, socket))
    try:
        while (message := await socket.receive())["type"] != "websocket.disconnect":
            _hear(guest, message, hear, most)
    finally:
        sending.cancel()


def _hear(guest: Guest, message: Any, hear: Callable[[Any], None], most: int) -> None:
    try:
        if (data := message.get("bytes")) is not None:
            hear(data)
            return
        text = message.get("text") or ""
        if len(text) > most:
            raise FrictionloopError(f"message: {len(text)} characters; at most {most}")
        hear(json.loads(text))
    except (FrictionloopError, ValueError, RecursionError) as error:
        guest.put({"type": "refused", "why": str(error)})


async def _send(guest: Guest, socket: WebSocket) -> None:
    with suppress(WebSocketDisconnect, RuntimeError):
        while True:
            message = await guest.next()
            if isinstance(message, bytes):
                await socket.send_bytes(message)
            else:
                await socket.send_text(json.dumps(message))
            await asyncio.sleep(0)  # a page that has gone is noticed between two messages, however many wait
