"""What opens the page loads little, and the rest comes beside the session."""

from __future__ import annotations

import gc
import subprocess
import sys

import pytest

from frictionloop.studio import background

OPENS = """
import sys
import frictionloop as fl
from frictionloop.live.engines import TwinEngine
from frictionloop.live.session import Session
from frictionloop.studio.room import Room
from frictionloop.studio.server import studio_app
studio_app(Room(Session(TwinEngine(fl.bench().evolve({"setpoint": {"kind": "effect"}})))))
heavy = {"xarray", "pandas", "h5py", "scipy.signal", "scipy.ndimage", "scipy.stats"}
print("loaded:", *sorted(heavy & set(sys.modules)))
from frictionloop.studio import background
background.load()
print("loaded:", *sorted(heavy & set(sys.modules)))
"""


@pytest.mark.slow
def test_what_opens_the_page_loads_no_filters_and_no_datasets():
    ran = subprocess.run([sys.executable, "-c", OPENS], capture_output=True, text=True, check=True)
    assert ran.stdout.splitlines() == ["loaded:", "loaded: h5py pandas scipy.ndimage scipy.signal scipy.stats xarray"]


def test_what_a_session_has_loaded_is_not_searched_for_garbage(monkeypatch):
    frozen, before = gc.get_freeze_count(), [[] for _ in range(1000)]
    with background.starting():
        assert not gc.isenabled()
        background.started()
        assert gc.isenabled()
        started, made = gc.get_freeze_count(), [[] for _ in range(1000)]
        assert started >= frozen + len(before)
        monkeypatch.delitem(sys.modules, background.MODULES[-1], raising=False)
        background.load()
        assert gc.get_freeze_count() >= started + len(made)
        monkeypatch.setattr(gc, "freeze", lambda: pytest.fail("loaded again"))
        background.load()  # for every count
    assert gc.isenabled()
