"""What linear laws of M_s 1.7 leave at the least of a comparison's own noise: three quarters of an hour.

``python -m studies.bounded`` keeps the table of *pages/limits-of-control.md*, "On the noise of the comparison", for
what ``studies.laws`` has kept, or for the file of another comparison on `bench()`.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np

import frictionloop as fl
from frictionloop.design.comparison import protocol
from frictionloop.parameters import System
from studies.kept import both, keep
from studies.laws import RUNS
from studies.robust_reach import robust_reach

COARSE = 0.99
"""What is left of the bound without what 0.6 Hz of resolution may add to it (`robust_reach`)."""
MEASURED = {0.0: 1.7}
"""Largest |S| of laws that are told the resonance of the device."""
KINDS = {"hold": protocol.HOLDS, "sines": protocol.SINES}
HEADS = (
    *("mm/s", "um", "task", "fingers", "bound", "larger", "both"),
    *("larger / oracle", "both / oracle"),
)
LAWS = ("clairvoyant", "oracle")


def within_reach(system: System, people: Any, speed_mm_s: float) -> np.ndarray:
    """Return which fingers can be given 0.9 N, and 0.3 N, all but a twentieth of the time, shape (fingers,)."""
    return np.asarray(protocol.reached(system, people, speed_mm_s, load_moves=True)["capable"].values)


def bounds_n(people: Any, seed: int, condition: protocol.Condition) -> np.ndarray:
    """Return the bound of each finger at the level of a task, disturbed as the task is: N."""
    level = float(condition.task.split()[1])
    own = fl.bench().evolve(protocol.overrides_of(condition))
    noise = protocol.noise_seed(seed, condition.task)
    found = robust_reach(own, people, seed=noise, levels_n=(level,), limits=MEASURED)
    return COARSE * found["bound_rms_n"].values


def of_tasks(runs: Any, name: str, law: str, at: dict[str, Any], able: np.ndarray) -> np.ndarray:
    """Return a metric of each task and finger."""
    return runs[name].sel({**at, "law": law}).transpose("task", "finger").values[:, able]


def rows(path: str) -> Iterator[list[Any]]:
    """Yield what is kept of each speed, slip length, kind of task and kind of fingers."""
    runs, bench = fl.load(path), fl.bench()
    seed = int(runs.attrs["seed"])
    people = protocol.population(bench, int(runs.attrs["fingers"]), seed)
    for speed in (20.0, 80.0):
        able = protocol.able(bench, people, speed)
        some, near = [people[i] for i in able.nonzero()[0]], within_reach(bench, people, speed)[able]
        for z in protocol.lengths_of(bench):
            for kind, tasks in KINDS.items():
                conditions = [protocol.Condition(speed, z, task) for task in tasks]
                bound = np.array([bounds_n(some, seed, each) for each in conditions]) ** 2
                at = {"speed_mm_s": speed, "slip_length_um": z, "task": list(tasks)}
                short, oracle = (of_tasks(runs, "rms_error", law, at, able) ** 2 for law in LAWS)
                slack = 1.0 - of_tasks(runs, "saturation_index", "clairvoyant", at, able)
                squares = bound, np.maximum(bound, short), short + slack * bound, oracle
                for name, who in (("capable", np.full(near.shape, True)), ("within reach", near)):
                    rms = [np.sqrt(each[:, who].mean(0)) for each in squares]
                    errors = (both(1e3 * each) for each in rms[:3])
                    ratios = (f"{np.median(each / rms[3]):.2f}" for each in rms[1:3])
                    yield [f"{speed:g}", f"{z:g}", kind, f"{who.sum()} {name}", *errors, *ratios]


if __name__ == "__main__":
    keep("bounded", "bounded", HEADS, rows(sys.argv[1] if sys.argv[1:] else str(RUNS)))
