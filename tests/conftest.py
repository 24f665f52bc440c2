"""What all tests share: how hypothesis searches, and what two workers must not both do."""

from __future__ import annotations

import gc
import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

# Nothing that modules and collected tests are made of goes before the end: nobody need look through it again and again.
gc.disable()

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
alone, bench = sys.argv[1] == "1", fl.bench()
kinds = ["pi", "lookup", "notch_pi", "limit_observer"]
steps = fl.Steps(times_s=(0.0, 0.004), levels_n=(0.5, 0.6))
systems = [
    fl.paper(),
    *(bench.evolve({"controller.kind": kind}) for kind in kinds),
    *(bench.evolve({"finger.slip_length_um": length_um}) for length_um in (0.0, 30.0)),
    bench.evolve({"finger.kind": "rigid"}),
    bench.evolve({"controller.jitter_s": 1e-5, "controller.lost_ticks": 0.01}),
    bench.evolve({"setpoint": steps, "disturbance": steps}),
]
for system in systems:
    if alone:
        fl.simulate(system, 0.01)
    else:
        fl.sweep(system, {"plate.max_amplitude_um": [2.3, 2.4, 2.5]}, 0.01, n_jobs=1)
"""
"""Fills the cache with tiles of single runs ("1"), or with those of sweeps, which take three runs or more at once."""
TOGETHER = (("tests/claims/",), ("tests/unit/cli/test_design_cli.py", "tests/unit/cli/test_cli_readme.py"))
"""Tests that share what takes long to compute, the report's results and a design: one worker takes them all."""
DEAREST = (
    *(name for names in TOGETHER for name in names),
    "tests/firmware/test_ceiling.py",
    "tests/experiments/test_study.py",
    "studies/tests/test_beyond.py",
    "tests/unit/test_blocks_from_outside_refused.py",
    "tests/unit/test_comparison.py",
    "tests/experiments/test_device_path.py",
    "tests/firmware/test_same_bits_m7.py",
    "tests/firmware/test_instructions.py",
    "studies/tests/test_linear_reach.py",
    "studies/tests/test_felt_reach.py",
    "tests/unit/test_blocks_from_outside.py",
    "tests/reference/test_bench_solver.py",
    "tests/unit/test_recording.py",
    "tests/unit/cli/test_cli_device.py",
    "tests/unit/test_caches_heal.py",
    "tests/unit/test_retune_notch.py",
    "tests/unit/test_design_leaning.py",
    "tests/protocol/test_recordings_survive.py",
    "tests/reference/test_independent_solver.py",
    "tests/unit/test_bench_bits.py",
    "tests/unit/test_bench_from_files.py",
    "tests/reference/test_sensor_waveform.py",
    "tests/unit/test_sweep_backends.py",
    "tests/unit/test_sweep_faults.py",
    "tests/firmware/test_check_registers.py",
    "tests/unit/test_elsewhere.py",
    "tests/unit/cli/test_cli_bench.py",
    "tests/unit/test_design_sensor.py",
    "tests/unit/test_digest.py",
    "tests/reference/test_linear_laws.py",
    "tests/unit/cli/test_cli_program.py",
)
"""What takes longest, slow tests with it, comes first where files keep their order (``--no-loadscope-reorder``)."""

SOAK = Path(__file__).with_name("soak.json")
"""What `make soak` found: the outcome of each campaign, and of which commit and versions."""
CAMPAIGNS = pytest.StashKey[list[str]]()
ROOT = SOAK.parents[1]
DECIDE = {
    "": ("quantities", "parameters", "physics", "sensing", "control", "rendering", "loop"),
    "firmware": ("firmware", "device"),
    "protocol": ("firmware", "device"),
    "experiments": ("device", "experiments", "live"),
    "reference": ("analysis", "hardware", "identification", "recordings"),
    "unit": ("analysis", "design", "hardware", "identification", "recordings"),
    "tests": ("analysis", "design", "report"),
}
"""Rooms that decide the campaigns of a folder, of all and besides."""
SOAKED = ("soak", True)
"""What says of a report that it is a campaign's, also to the process that other workers report to."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Remember the campaigns before they are left out (tests/unit/test_budget.py), and mark what they will report."""
    campaigns = [item for item in items if item.get_closest_marker("soak")]
    config.stash[CAMPAIGNS] = [item.nodeid for item in campaigns]
    for item in campaigns:
        item.user_properties.append(SOAKED)
    items.sort(key=_rank)


def pytest_collection_finish() -> None:
    """Look for garbage from now on, but not among what collecting has made."""
    gc.freeze()
    gc.enable()


class Soak:
    """Store what the campaigns that were run found, beside what is stored of the others; tell what is of other code."""

    def __init__(self) -> None:
        self.found: dict[str, dict[str, Any]] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Keep outcome and time of a campaign."""
        outcome = "xfailed" if hasattr(report, "wasxfail") else report.outcome
        if SOAKED in report.user_properties and outcome != "skipped" and (report.when == "call" or not report.passed):
            self.found[report.nodeid] = {
                "outcome": outcome, "seconds": round(report.duration, 1), "code": deciding_code(report.nodeid),
                "numba": version("numba"), "numpy": version("numpy"),
            }  # fmt: skip
            if figures := dict(each for each in report.user_properties if each != SOAKED):
                self.found[report.nodeid]["figures"] = figures

    def pytest_sessionfinish(self) -> None:
        """Write the file."""
        if self.found:
            kept = json.loads(SOAK.read_text()) if SOAK.exists() else {}
            SOAK.write_text(json.dumps(dict(sorted((kept | self.found).items())), indent=1) + "\n")

    def pytest_terminal_summary(self, terminalreporter: Any, config: pytest.Config) -> None:
        """Tell the figures of what was run; how many stored campaigns did not pass, and how many other code decided."""
        for name, found in self.found.items():
            for what, figure in found.get("figures", {}).items():
                terminalreporter.line(f"{name.rpartition('::')[2]}: {what} {figure}")
        if config.args_source is pytest.Config.ArgsSource.TESTPATHS:
            stored = json.loads(SOAK.read_text(encoding="utf-8"))
            failed = sum(found["outcome"] == "failed" for found in stored.values())
            stale = sum(found.get("code") != deciding_code(name) for name, found in stored.items())
            terminalreporter.line(f"campaigns: {len(stored)} stored, {failed} failed, {stale} of other code: make soak")


@pytest.fixture(autouse=True, scope="module")
def _registers_nothing() -> Iterator[None]:
    """Blocks from outside enter the fingerprint of every sweep: no file may leave one behind for the next."""
    yield
    blocks = sys.modules.get("frictionloop.loop.registered_blocks")
    left = blocks.registered() if blocks else []
    if blocks:
        blocks.forget()
    assert not left, f"leaves blocks from outside behind: {left}"


@pytest.fixture(autouse=True, scope="session")
def _tells_no_progress() -> Iterator[None]:
    """What is under way is told after some seconds: on a busy machine that would stand beside what a test looks for."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("frictionloop.loop.progress.FIRST_S", 1e9)
        yield


@pytest.fixture
def is_stored(request: pytest.FixtureRequest) -> bool:
    """Return whether what a campaign found is stored, of this code."""
    name = request.node.nodeid
    return json.loads(SOAK.read_text(encoding="utf-8")).get(name, {}).get("code") == deciding_code(name)


@pytest.fixture
def campaigns(pytestconfig: pytest.Config) -> tuple[list[str], dict[str, Any]]:
    """Return the campaigns among the tests that were collected, and what is stored of all."""
    return pytestconfig.stash[CAMPAIGNS], json.loads(SOAK.read_text(encoding="utf-8"))


def _rank(item: pytest.Item) -> int:
    found = [place for place, name in enumerate(DEAREST) if item.nodeid.startswith(name)]
    return found[0] if found else len(DEAREST)


@cache
def deciding_code(name: str) -> str:
    """Return a digest of the code that decides a campaign: its file, and the rooms that its folder tests."""
    file = Path(name.partition("::")[0])
    rooms = [ROOT / "src" / "frictionloop" / room for room in (*DECIDE[""], *DECIDE.get(file.parent.name, ()))]
    paths = [ROOT / file, *(path for room in rooms for path in sorted(room.rglob("*.py")))]
    if file.parent.name in ("firmware", "protocol"):
        paths += sorted((ROOT / "firmware" / "core").glob("*.[ch]"))
    return hashlib.sha256(b"\0".join(path.read_bytes() for path in paths if path.exists())).hexdigest()[:16]


def pytest_configure(config: pytest.Config) -> None:
    """Store the campaigns where results come together, not in each worker."""
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(Soak())


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes(config: pytest.Config) -> None:
    """Fill the cache of tiles, those of single runs and of sweeps side by side, before every worker compiles them."""
    if config.args_source is not pytest.Config.ArgsSource.TESTPATHS:
        return  # of some tests nobody knows what they need
    halves = [subprocess.Popen([sys.executable, "-c", COMPILE, lanes]) for lanes in ("1", "32")]
    for half in halves:
        half.wait()  # what does not compile is told by the tests that need it


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Let a worker take whole files (``--dist loadfile``), and of `TOGETHER` all that is named."""
    if config.getvalue("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class ByFile(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            shared = (names[0] for names in TOGETHER if nodeid.startswith(names))
            return next(shared, None) or super()._split_scope(nodeid)

    return ByFile(config, log)
