"""What all tests share: how hypothesis searches, and what two workers must not both do."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any

import pytest
from hypothesis import settings

# Matrices here are small, and threads that wait for one another cost several times what they save, most of all
# where each core has a worker of its own. It must be set before the first import of NumPy.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# The same examples on every machine, and no deadline, because the first example compiles the kernel.
settings.register_profile("default", deadline=None, derandomize=True, max_examples=100)
# `pytest --hypothesis-profile=explore` looks further, with new examples each time.
settings.register_profile("explore", deadline=None, max_examples=2000)
settings.load_profile("default")

COMPILE = """
import sys
import frictionloop as fl
kinds = ["pi", "lookup", "oracle", "notch_pi", "observer", "super_twisting", "tracker"]
for contact in ("dahl", "slider", "lugre"):
    for kind in kinds if contact == "dahl" else kinds[:1]:
        bench = fl.bench().evolve({"finger.contact": contact, "controller.kind": kind})
        if sys.argv[1] == "0":
            fl.simulate(bench, 0.01)
        else:
            fl.sweep(bench, {"setpoint.offset_n": [0.5, 0.6]}, 0.01, n_jobs=1)
if sys.argv[1] == "0":
    fl.simulate(fl.paper(), 0.01)
else:
    fl.sweep(fl.paper(), {"controller.kp": [1.0, 2.0]}, 0.01, n_jobs=1)
"""
TOGETHER = "tests/claims/"
"""Tests that share the report's results, which take longest of all to compute: one worker takes them all.

They come first where files keep their order (``--no-loadscope-reorder``), so that the other worker fills the end.
"""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes() -> None:
    """Fill the cache of tiles, those of single runs and of sweeps side by side, before every worker compiles them."""
    halves = [subprocess.Popen([sys.executable, "-c", COMPILE, half]) for half in ("0", "1")]
    for half in halves:
        half.wait()  # what does not compile is told by the tests that need it


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Let a worker take whole files (``--dist loadfile``), and of the claims the whole folder."""
    if config.getvalue("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class ByFile(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return TOGETHER if nodeid.startswith(TOGETHER) else super()._split_scope(nodeid)

    return ByFile(config, log)
