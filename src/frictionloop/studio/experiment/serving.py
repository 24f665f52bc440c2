"""Serving the pages of an experiment from a thread, while the session runs in the one that signals reach."""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from frictionloop.quantities.extra import needed
from frictionloop.studio.experiment.desk import Desk
from frictionloop.studio.listening import listening
from frictionloop.studio.safe import LOOPBACK, Doors

LAST_S = 1.0
"""Time in which pages still hear that a session is over (assumed)."""


class Addresses(NamedTuple):
    """Where the pages are; each address holds its token."""

    participant: str
    experimenter: str


@contextmanager
def served(desk: Desk, host: str = "127.0.0.1", port: int = 0) -> Iterator[Addresses]:
    """Serve the pages of a session, and yield their addresses.

    Parameters
    ----------
    desk : Desk
        The session's pages.
    host : str
        Address to listen at; any but this machine's own lets the two pages be on other machines.
    port : int
        Port; 0 takes a free one.

    Raises
    ------
    FrictionloopError
        For an address that cannot be listened at, or a missing extra.
    """
    uvicorn = needed("uvicorn", "uvicorn", "studio")
    needed("starlette", "starlette", "studio")
    from frictionloop.studio.experiment.server import experiment_app

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
