"""What a page needs only when it is open: loaded beside the session, as it takes longer than what opens the page."""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from threading import Lock

MODULES = (
    "scipy.signal",
    "frictionloop.loop.reference_runs",
    "frictionloop.studio.effect_feasibility",
    "frictionloop.studio.uploads",
)
"""They bring filters, Datasets and files along."""
YIELDS_S = 0.5e-3
"""After how long a thread that works beside the session gives way to it (assumed: a tenth of a block)."""
_loading = Lock()


def load() -> None:
    """Load all of it, which takes a second the first time; for a thread beside the session."""
    with _loading:  # two threads that load what loads one another would find half of it
        if all(name in sys.modules for name in MODULES):
            return
        for name in MODULES:
            import_module(name)
        if gc.get_freeze_count():  # which counts them one by one, in 20 ms
            gc.freeze()


@contextmanager
def starting() -> Iterator[None]:
    """Let a session start and run: no search for garbage before it is `started`, and threads beside it that give way.

    The search through all that is loaded takes 0.2 s of the start, and stands a session still for 0.15 s.
    """
    before = sys.getswitchinterval()
    gc.disable()
    sys.setswitchinterval(YIELDS_S)
    try:
        yield
    finally:
        sys.setswitchinterval(before)
        gc.enable()


def started() -> None:
    """Take note that a session runs, if it was `starting`: what is there now stays, and is never searched again."""
    if not gc.isenabled():
        gc.freeze()
        gc.enable()
