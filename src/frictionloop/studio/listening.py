"""The socket that a server of pages listens at, and the event loop that wakes in time for what is due."""

from __future__ import annotations

import asyncio
import selectors
import socket

from frictionloop.quantities import FrictionloopError


def listening(host: str, port: int) -> socket.socket:
    """Return a socket that is bound, so that its address is known before the server is up.

    It sends at once what is written: asyncio asks for that only where a socket names TCP as its protocol. Else a frame
    waits until the page acknowledges the one before it, which it does with its next pointer event.

    Parameters
    ----------
    host : str
        Name or number of the interface.
    port : int
        Number of the port, 0 for a free one.

    Raises
    ------
    FrictionloopError
        For an address that cannot be listened at.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    made = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        made.bind((host.strip("[]"), port))
    except OSError as error:
        made.close()
        raise FrictionloopError(f"host {host}, port {port}: cannot listen there ({error.strerror})") from None
    return made


def prompt_loop() -> asyncio.AbstractEventLoop:
    """Return an event loop whose timers are good to the 0.1 ms; the usual one waits in whole milliseconds.

    It takes as many sockets as ``select`` does, 1024 on most systems: pages beyond that are not let in.
    """
    return asyncio.SelectorEventLoop(selectors.SelectSelector())
