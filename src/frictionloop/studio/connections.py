"""Pages at their sockets: who may come in, where a server listens, what waits for a page, and what it says."""

from __future__ import annotations

import asyncio
import hmac
import json
import mimetypes
import secrets
import selectors
import socket
import tempfile
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, Response
from starlette.websockets import WebSocket, WebSocketDisconnect

from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.studio.frames import CROWD_FRAME, FRAME

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}


class Doors(NamedTuple):
    """What a request must bring: a Host of these, and a token where there is one."""

    hosts: tuple[str, ...] = LOOPBACK
    """Names that the page may be asked for by, without their port; empty: any, behind a token."""
    token: str = ""
    """Lets its bearer drive; empty: nobody needs one."""
    watch_token: str = ""
    """Lets its bearer watch."""

    def role(self, request: HTTPConnection) -> str:
        """Return ``"drive"`` or ``"watch"``, or an empty text for who may not come in."""
        host = request.headers.get("host", "")
        name = host if host.endswith("]") else host.rpartition(":")[0] or host
        if self.hosts and name not in self.hosts:
            return ""
        origin = request.headers.get("origin")
        if origin is not None and origin not in (f"http://{host}", f"https://{host}"):
            return ""
        if not self.token:
            return "drive"
        given = request.query_params.get("token", "")
        if hmac.compare_digest(given.encode(), self.token.encode()):
            return "drive"
        return "watch" if hmac.compare_digest(given.encode(), self.watch_token.encode()) else ""


def open_to_network() -> Doors:
    """Return the doors of a studio that other machines reach: any name, with tokens of 128 bit."""
    return Doors((), secrets.token_urlsafe(16), secrets.token_urlsafe(16))


WAITING, MOST_WAITING = 64, 4096
"""Frames that wait for a slow page, a third of a second, before the oldest goes; messages before the page is let go."""
RENEWED = ("status", "numbers", "crowd")
"""Messages of which the newest says all that the one before it did."""


class Guest:
    """A page that is connected."""

    def __init__(self, may_drive: bool) -> None:
        self.may_drive, self.listens, self.lost = may_drive, False, 0
        self.crowd = False
        """Whether it looks at the row of fingers."""
        self.ahead = False
        """Whether it is told what of the effect will not arrive."""
        self.key = secrets.token_urlsafe(16)
        """Tells its requests from those of other pages."""
        self._waiting: deque[bytes | dict[str, Any]] = deque()
        self._there = asyncio.Event()

    def put(self, message: bytes | dict[str, Any]) -> None:
        """Let a message wait to be sent: the oldest frame goes when many wait, and nothing else ever does."""
        if _is_frame(message):
            frames = [k for k, each in enumerate(self._waiting) if _is_frame(each)]
            if len(frames) >= WAITING:
                del self._waiting[frames[0]]
                self.lost += 1
        elif isinstance(message, dict) and message["type"] in RENEWED:
            for each in list(self._waiting):
                if isinstance(each, dict) and each["type"] == message["type"]:
                    self._waiting.remove(each)
        self._waiting.append(message)
        self._there.set()

    async def next(self) -> bytes | dict[str, Any]:
        """Return the next message to send; a page for which too many wait is let go, and comes anew."""
        while not self._waiting:
            self._there.clear()
            await self._there.wait()
        if len(self._waiting) > MOST_WAITING:
            raise WebSocketDisconnect
        return self._waiting.popleft()


def _is_frame(message: bytes | dict[str, Any]) -> bool:
    return isinstance(message, bytes) and message[0] in (FRAME, CROWD_FRAME)


BACKLOG = 128
"""Connections that wait until the server is up."""


def listening(host: str, port: int) -> socket.socket:
    """Return a socket that listens: its address is known, and may be opened, before the server is up.

    It sends at once what is written: asyncio asks for that only where a socket names TCP as its protocol. Else a frame
    waits until the page acknowledges the one before it, which it does with its next pointer event.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    made = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        made.bind((host.strip("[]"), port))
        made.listen(BACKLOG)
    except OSError as error:
        made.close()
        raise FrictionloopError(f"host {host}, port {port}: cannot listen there ({error.strerror})") from None
    return made


def prompt_loop() -> asyncio.AbstractEventLoop:
    """Return an event loop whose timers are good to the 0.1 ms; the usual one waits in whole milliseconds.

    It takes as many sockets as ``select`` does, 1024 on most systems: pages beyond that are not let in.
    """
    return asyncio.SelectorEventLoop(selectors.SelectSelector())


def file_answer(files: Mapping[str, Path], name: str) -> Response:
    """Return one of our files, read at once: a thread that reads it takes three times as long, and a page has forty."""
    if name not in files:
        return PlainTextResponse("no such file", 404, headers=HEADERS)
    return Response(files[name].read_bytes(), media_type=mimetypes.guess_type(name)[0], headers=HEADERS)


def why_of(error: Exception) -> str:
    """Return in words what something died of that must not take the session with it."""
    return str(error) if isinstance(error, FrictionloopError) else f"{type(error).__name__}: {error}"


def refused() -> Response:
    """Return the answer to who may not come in."""
    return PlainTextResponse("Use the address that was printed.", 403, headers=HEADERS)


@contextmanager
def as_file(content: bytes, file: str, name: str) -> Iterator[Path]:
    """Yield the path of a file with what a page has sent, which errors call by a name."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / file
        path.write_bytes(content)
        try:
            yield path
        except FrictionloopError as error:
            raise FrictionloopError(str(error).replace(str(path), name)) from None


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
            raise must_be("message", len(text), f"at most {most}", "characters")
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
    with suppress(RuntimeError):  # it has gone, or it is let go
        await socket.close(1013)
