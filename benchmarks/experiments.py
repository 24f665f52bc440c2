"""Speed of experiments: an update of psi, and a study of 24 participants, 4 conditions and 60 trials of two strokes.

python -m benchmarks.experiments            # the update alone
python -m benchmarks.experiments --study    # the study too, one to two minutes
python -m benchmarks.experiments --write    # both, into benchmarks/results/experiments.md
"""

import os
import resource
import sys
import time
from pathlib import Path

import numpy as np

from frictionloop.experiments import Psi, read_protocol
from frictionloop.experiments.study_run import simulate_trials

UPDATE_S, STUDY_S = 20e-3, 120.0
"""Goals: psi on a grid of 60 x 30 x 10, and the study on two cores."""


def update_s(repeats=50):
    """Median time of an update and the choice of the next level, s."""
    levels = np.linspace(0.005, 0.3, 40)
    psi = Psi(levels, np.linspace(0.005, 0.3, 60), np.geomspace(0.01, 0.2, 30), np.linspace(0.0, 0.1, 10), trials=1000)
    times = []
    for k in range(repeats):
        start = time.perf_counter()
        psi.add_response(k % 3 > 0, psi.level + 0.001)
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def study_s(participants=24):
    """Wall and processor time of the study, s; both halves have closed and open loop."""
    plans = [read_protocol(name) for name in ("study-friction", "study-grating")]
    simulate_trials(plans[0].evolve({"stop.trials": 1}), participants=1, progress=False)  # compiles
    start, cpu = time.perf_counter(), time.process_time()
    for plan in plans:
        simulate_trials(plan, participants=participants)
    return time.perf_counter() - start, time.process_time() - cpu


HEAD = """# Experiments

| what | measured | goal |
|---|---|---|
"""
RESULTS = Path(__file__).parent / "results" / "experiments.md"


def table(update, wall, cpu, memory_mb, others):
    """Return the rows as a page."""
    size = f"24 participants x 4 conditions x 60 trials, {os.cpu_count()} cores"
    return (
        HEAD
        + f"| psi-marginal, 60 x 30 x 10 values: one update | {1e3 * update:.1f} ms | {1e3 * UPDATE_S:.0f} ms |\n"
        + f"| study, {size} | {wall:.0f} s | {STUDY_S:.0f} s |\n"
        + f"| the same, processor time | {cpu:.0f} s | |\n"
        + f"| the same, most memory | {memory_mb:.0f} MB | |\n\n"
        + f"Load of the machine before it began: {others:.1f}.\n"
    )


if __name__ == "__main__":
    load = os.getloadavg()[0]
    found = update_s()
    print(f"psi update: {1e3 * found:.1f} ms (goal {1e3 * UPDATE_S:.0f} ms)")
    if {"--study", "--write"} & set(sys.argv):
        wall, cpu = study_s()
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"study: {wall:.0f} s, of processor {cpu:.0f} s (goal {STUDY_S:.0f} s), {memory:.0f} MB at most")
        if "--write" in sys.argv:
            RESULTS.write_text(table(found, wall, cpu, memory, load))
