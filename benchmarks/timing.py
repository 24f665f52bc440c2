"""Take times side by side on a machine that is shared with others, and say what the machine is."""

from __future__ import annotations

import gc
import os
import platform
import statistics
import subprocess
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

BURST_S = 0.3
"""Calls much shorter than this are repeated for this long in each round; the shortest counts."""
BUSY = 0.08
"""Share of the machine used by others above which a round waits."""


@dataclass
class Contender:
    """A call to time. `part` is the share of the work it does; below one, the time is extrapolated."""

    name: str
    call: Callable[[], Any]
    rounds: int = 7
    part: float = 1.0
    note: str = ""
    threads: int = 1
    seconds: list[float] = field(default_factory=list)

    @property
    def best(self) -> float:
        return min(self.seconds) / self.part

    @property
    def spread(self) -> float:
        """Median of the rounds over the best, minus one."""
        return statistics.median(self.seconds) / min(self.seconds) - 1


def side_by_side(contenders: Iterable[Contender], patience_s: float, told: Callable[[str], None]) -> list[Contender]:
    """Interleave the contenders (A B C A B C ...) after one warm-up each; a slow one takes part in fewer rounds."""
    waiting, ready = Patience(patience_s), list(contenders)
    for contender in ready:
        told(f"warm-up: {contender.name}")
        contender.call()
    for turn in range(max(contender.rounds for contender in ready)):
        for contender in ready:
            if turn < contender.rounds:
                waiting.for_quiet()
                told(f"round {turn + 1}: {contender.name}")
                contender.seconds.append(shortest(contender.call))
    return ready


def shortest(call: Callable[[], Any]) -> float:
    """Shortest of the calls that fit into a burst; the collector stays out of it."""
    gc.collect()
    gc.disable()
    try:
        best, began = float("inf"), time.perf_counter()
        while True:
            start = time.perf_counter()
            call()
            stop = time.perf_counter()
            best = min(best, stop - start)
            if stop - began + best > BURST_S:
                return best
    finally:
        gc.enable()


class Patience:
    """Waits while other processes keep the machine busy, up to a limit for the whole group."""

    def __init__(self, limit_s: float) -> None:
        self.left_s = limit_s if Path("/proc/stat").exists() else 0.0

    @staticmethod
    def _ticks() -> tuple[int, int]:
        user, nice, system, idle, wait, *rest = map(int, Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:8])
        return user + nice + system + sum(rest), user + nice + system + sum(rest) + idle + wait

    def for_quiet(self) -> None:
        while self.left_s > 0:
            (used, total), pause = self._ticks(), 0.15
            time.sleep(pause)
            self.left_s -= pause
            now_used, now_total = self._ticks()
            if now_used - used <= BUSY * max(now_total - total, 1):
                return


def cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def machine(compiler: str) -> dict[str, Any]:
    """Processor, system, versions and commit: what a figure needs to be compared with another."""
    names = ("frictionloop", "numpy", "scipy", "numba", "jax", "diffrax", "control", "drake", "pathsim")
    return {
        "processor": _processor(),
        "cores": cores(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "compiler": compiler,
        "packages": {name: found for name in names if (found := _version(name))},
        "commit": _git("describe", "--always", "--dirty", "--abbrev=12"),
    }


def commit_date() -> str | None:
    return _git("show", "-s", "--format=%cs", "HEAD")


def _processor() -> str:
    listing = Path("/proc/cpuinfo")
    text = listing.read_text() if listing.exists() else ""
    named = [line.split(":", 1)[1].strip() for line in text.splitlines() if line.startswith("model name")]
    wide = " (AVX-512)" if "avx512f" in text else " (AVX2)" if " avx2" in text else ""
    return (named[0] if named else platform.processor() or platform.machine()) + wide


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _git(*words: str) -> str | None:
    try:
        told = subprocess.run(["git", *words], cwd=Path(__file__).parent, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return told.stdout.strip() or None
