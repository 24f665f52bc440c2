"""What linear laws with the tracker's margins leave at the least of a comparison's own noise: half an hour.

``python docs/_tools/bounded.py tournament/results.h5`` prints the table of *limits-of-control*, "Bearing a resonance",
to a digit more, for a comparison on `bench()`. $R^2$ of a rms e over the sines is 1 - e^2 / 0.0317 N^2.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

import frictionloop as fl
from frictionloop.design.robust_reach import robust_reach
from frictionloop.design.tournament import protocol
from frictionloop.design.tournament.scores import spread

COARSE = 0.99
"""What is left of the bound without what 0.6 Hz of resolution may add to it (`robust_reach`)."""
KINDS = {"hold": protocol.HOLDS, "sines": protocol.SINES}
LAWS = ("clairvoyant", "tracker", "oracle")


def bounds_n(people: Any, seed: int, condition: protocol.Condition) -> np.ndarray:
    """Return the bound of each finger at the level of a task, disturbed as the task is: N."""
    level = float(condition.task.split()[1])
    own = fl.bench().evolve(protocol.overrides_of(condition))
    found = robust_reach(own, people, seed=protocol.noise_seed(seed, condition.task), levels_n=(level,))
    return COARSE * found["bound_rms_n"].values


def of_tasks(runs: Any, name: str, law: str, at: dict[str, Any], able: np.ndarray) -> np.ndarray:
    """Return a metric of each task and finger."""
    return runs[name].sel({**at, "law": law}).transpose("task", "finger").values[:, able]


def told(values: np.ndarray) -> str:
    """Return median / worst decile in mN."""
    return " / ".join(f"{1e3 * value:.2f}" for value in spread(values, False))


def main(path: str) -> None:
    """Print a row for each speed, contact, kind of task and kind of fingers."""
    runs, bench = fl.load(path), fl.bench()
    seed = int(runs.attrs["seed"])
    people = protocol.population(bench, int(runs.attrs["fingers"]), seed)
    for speed in (20.0, 80.0):
        able = protocol.able(bench, people, speed)
        some, near = [people[i] for i in able.nonzero()[0]], protocol.within_reach(bench, people, speed)[able]
        for contact in ("dahl", "slider"):
            for kind, tasks in KINDS.items():
                conditions = [protocol.Condition(speed, contact, task) for task in tasks]
                bound = np.array([bounds_n(some, seed, each) for each in conditions]) ** 2
                at = {"speed_mm_s": speed, "contact": contact, "task": list(tasks)}
                short, ours, oracle = (of_tasks(runs, "rms_error", law, at, able) ** 2 for law in LAWS)
                slack = 1.0 - of_tasks(runs, "saturation_index", "clairvoyant", at, able)
                rms = [np.sqrt(each.mean(0)) for each in (bound, short + slack * bound, ours, oracle)]
                larger = np.maximum(rms[0], np.sqrt(short.mean(0)))
                for name, who in (("capable", np.full(near.shape, True)), ("within reach", near)):
                    least, both, left, ideal = (each[who] for each in rms)
                    errors = " | ".join(told(each) for each in (least, larger[who], both, left))
                    ratios = " | ".join(f"{np.median(each / ideal):.2f}" for each in (both, left))
                    where = f"{speed:g} | {contact} | {kind} | {who.sum()} {name}"
                    print(f"| {where} | {errors} | {ratios} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
