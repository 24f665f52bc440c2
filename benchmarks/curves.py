"""Cost against lanes, duration and threads; peak memory against duration; start-up of fresh processes."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import ours
from build import Reference
from contenders import KI, KP, OURS, QUIET, C
from timing import Contender, cores, side_by_side

LANES = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048)
DURATIONS_S = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
MEMORY_S = (1.0, 10.0, 100.0)
MEMORY = """
import resource, sys
from pathlib import Path
import numpy as np
import ours
if sys.argv[2] == "bench":
    ours.stepped(64, 1, float(sys.argv[1]))
else:
    ours.grid(np.geomspace(1, 10, 64), np.array([2.0]), 1, float(sys.argv[1]), noise=True)
# On Linux ru_maxrss outlives exec and so may hold the peak of the parent; VmHWM is that of this program alone.
status = Path("/proc/self/status")
lines = status.read_text().splitlines() if status.exists() else []
kib = [int(line.split()[1]) for line in lines if line.startswith("VmHWM:")]
most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(kib[0] / 2**10 if kib else most * (1 if sys.platform == "darwin" else 1024) / 2**20)
"""
Told = Callable[[str], None]


def measure(c: Reference, patience_s: float, told: Told) -> dict[str, Any]:
    """All curves as {name: {x: [...], contender: [seconds, ...]}}."""
    return {
        "lanes": _curve(LANES, partial(_lanes, c), patience_s, told),
        "duration_s": _curve(DURATIONS_S, partial(_duration, c), patience_s, told),
        "threads": _curve(tuple(range(1, max(2 * cores(), 2) + 1)), partial(_threads, c), patience_s, told),
        "memory": _memory(told),
    }


def _curve(
    xs: tuple[float, ...], at: Callable[[Any], dict[str, Callable[[], Any]]], patience_s: float, told: Told
) -> Any:
    """Interleave all points of a curve, so that a busy moment does not bend it."""
    calls = {(name, x): call for x in xs for name, call in at(x).items()}
    timed = side_by_side(
        [Contender(f"{name} at {x:g}", call, 5) for (name, x), call in calls.items()], patience_s, told
    )
    curve: dict[str, list[float]] = {}
    for (name, _), contender in zip(calls, timed, strict=True):
        curve.setdefault(name, []).append(contender.best)
    return {"x": list(xs), **curve}


def _lanes(c: Reference, lanes: int) -> dict[str, Callable[[], Any]]:
    """2 s of signal, one thread."""
    kp, ki = np.geomspace(1, 10, lanes), np.full(lanes, KI)
    calls: dict[str, Callable[[], Any]] = {C: lambda: c.grid(QUIET, kp, ki, 10_000, 1)}
    if ours.version():
        calls[OURS] = partial(ours.grid, kp, ki[:1], 1, 2.0)
    return calls


def _duration(c: Reference, duration_s: float) -> dict[str, Callable[[], Any]]:
    """One run with traces and a sweep of 64 lanes, one thread."""
    periods, slow = round(duration_s * QUIET.rate_hz), replace(QUIET, noise_rms=1e-5, sweep_s=max(10.0, duration_s))
    kp = np.geomspace(1, 10, 64)
    calls: dict[str, Callable[[], Any]] = {
        f"{C}, one run": lambda: c.one(slow, KP, KI, periods),
        f"{C}, 64 lanes": lambda: c.grid(slow, kp, np.full(64, KI), periods, 1),
    }
    if ours.version():
        calls[f"{OURS}, one run"] = partial(ours.one, KP, KI, duration_s)
        calls[f"{OURS}, 64 lanes"] = partial(ours.grid, kp, np.array([KI]), 1, duration_s, noise=True)
    return calls


def _threads(c: Reference, threads: int) -> dict[str, Callable[[], Any]]:
    """1024 lanes, 2 s."""
    kp = np.geomspace(1, 10, 1024)
    calls: dict[str, Callable[[], Any]] = {C: lambda: c.grid(QUIET, kp, np.full(1024, KI), 10_000, threads)}
    if ours.version():
        calls[OURS] = partial(ours.grid, kp, np.array([KI]), threads, 2.0)
    return calls


def _memory(told: Told) -> dict[str, list[float]]:
    """Peak memory in MiB of a fresh process that sweeps 64 lanes (not on Windows, which has no getrusage).

    On the bench with every metric that is computed while the loop runs and holds filters or times: perceptual index,
    step times.
    """
    if not ours.version() or sys.platform == "win32":
        return {}
    peaks: dict[str, list[float]] = {}

    def peak(which: str, duration_s: float) -> float:
        command = [sys.executable, "-c", MEMORY, str(duration_s), which]
        run = subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, text=True, check=True)
        return float(run.stdout.split()[-1])

    for which, name in (("paper", OURS), ("bench", f"{OURS}, bench")):
        peak(which, MEMORY_S[0])  # fills the cache of compiled code: a compiler takes 100 MiB
        for duration_s in MEMORY_S:
            told(f"memory of {duration_s:g} s")
            peaks.setdefault(name, []).append(peak(which, duration_s))
    return {"x": list(MEMORY_S), **peaks}


def bench(threads: int, quick: bool) -> Iterator[tuple[str, list[Contender], int]]:
    """The bench block by block over 256 lanes, without and with an effect, and a population of 1,000 fingers."""
    rounds = 3 if quick else 7
    for section, steps in (("bench", ours.bench_steps()), ("effect", ours.effect_steps())):
        yield (
            section,
            [
                Contender(name, partial(ours.bench, *step, 256, threads), rounds, threads=threads)
                for name, step in steps.items()
            ],
            256,
        )
    whole = Contender("1,000 fingers", partial(ours.population, 1000, threads), rounds, threads=threads)
    yield "population", [whole], 1000


def start_up(patience_s: float, told: Told) -> list[Contender]:
    """Whole processes of the command line, after one run that fills the cache of compiled code."""
    if not ours.version():
        return []
    with tempfile.TemporaryDirectory() as folder:
        run = partial(subprocess.run, cwd=folder, capture_output=True, check=True)
        calls = [Contender(name, partial(run, command), 5) for name, command in ours.commands().items()]
        return side_by_side(calls, patience_s, told)


def cold(patience_s: float, told: Told) -> list[Contender]:
    """The first run of a preset after installation: whole processes with an empty cache of compiled code."""
    if not ours.version():
        return []

    def first(command: list[str]) -> None:
        with tempfile.TemporaryDirectory() as folder:
            environment = os.environ | {"NUMBA_CACHE_DIR": folder}
            subprocess.run(command, cwd=folder, env=environment, capture_output=True, check=True)

    run = [sys.executable, "-m", "frictionloop", "simulate", "--duration-s", "1", "--preset"]
    calls = [Contender(f"simulate --preset {name}", partial(first, [*run, name]), 3) for name in ("paper", "bench")]
    return side_by_side(calls, patience_s, told)


def draw(curves: dict[str, Any], path: Path) -> None:
    """Draw the curves as one figure."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 4, figsize=(13, 3.2), layout="constrained")
    names = {
        "lanes": ("lanes (2 s, 1 thread)", "s"),
        "duration_s": ("duration (s)", "s"),
        "threads": ("threads (1024 lanes, 2 s)", "s"),
        "memory": ("duration of 64 lanes (s)", "peak MiB"),
    }
    for axis, (key, (x_label, y_label)) in zip(axes, names.items(), strict=True):
        for index, (name, values) in enumerate((n, v) for n, v in curves[key].items() if n != "x"):
            style = "-" if name.startswith(OURS) else "--"
            axis.plot(curves[key]["x"], values, style, marker="os^D"[index], markersize=4, label=name)
        axis.set(xlabel=x_label, ylabel=y_label)
        if key in ("lanes", "duration_s"):
            axis.set(xscale="log", yscale="log")
        else:
            axis.set_ylim(bottom=0)
        if curves[key]:
            axis.legend(frameon=False, fontsize=7)
    path.parent.mkdir(parents=True, exist_ok=True)
    plt.rcParams["svg.hashsalt"] = "frictionloop"
    figure.savefig(path, metadata={"Date": None})
