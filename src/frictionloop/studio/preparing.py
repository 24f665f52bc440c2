"""Another loop is compiled beside the session, which goes on meanwhile, and is put in force when it is ready."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError
from frictionloop.studio.room import Room

SOON_S = 0.4
"""A loop that is ready so soon is not spoken of."""
WAITS = "Compiling, once."


def is_ready(room: Room, system: System) -> bool:
    """Tell whether the engine can take a System at once; one that compiles nothing always can."""
    ready = getattr(room.session.engine, "ready", None)
    return ready is None or bool(ready(system))


async def put_when_ready(room: Room, make: Callable[[System], System], put: Callable[[System], None]) -> None:
    """Let the engine compile what a System needs, and put in force what ``make`` then makes of the System there is.

    Pages are told that it takes its time, and why it cannot be if it cannot.
    """
    engine: Any = room.session.engine
    try:
        system = make(engine.system)
        work = asyncio.ensure_future(asyncio.to_thread(engine.prepare, system))
        done, _ = await asyncio.wait({work}, timeout=SOON_S)
        if not done:
            room.tell({"type": "said", "why": WAITS})
        await work
        put(make(engine.system))
        room.tell_status()
    except FrictionloopError as error:
        room.tell({"type": "refused", "why": str(error)})
    except Exception as error:  # what does not compile must not take the session with it
        room.tell({"type": "refused", "why": f"{type(error).__name__}: {error}"})
