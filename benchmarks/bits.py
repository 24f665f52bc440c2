"""Do traces and metrics still have the same bits? Run before a change of the kernel and after it.

    python benchmarks/bits.py > before.json
    python benchmarks/bits.py --against before.json     names what differs, and by how much; exit status 1

The numbers are those of one machine and of the versions in requirements/lock.txt: they are compared, not kept.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import frictionloop as fl

LAWS = ("lookup", "pi", "filtered_pi", "notch_pi", "limit_observer")
LENGTHS_UM = (0.0, 11.5)
NOTCH = {"controller.kind": "notch_pi", "controller.kp": 3.8, "controller.ki": 80.0}
GAINS = {"notch_pi": NOTCH, "filtered_pi": {"controller.kp": 0.062, "controller.ki": 134.0}}
STEPS = {
    "setpoint.kind": "steps",
    "setpoint.times_s": [0.1 * i for i in range(20)],
    "setpoint.levels_n": [0.4 if i % 2 else 0.7 for i in range(20)],
}
PAPER = {
    "paper": {},
    "delay": {"controller.delay_s": 100e-6},
    "long delay": {"controller.delay_s": 350e-6},
    "table": {"controller.model.table_size": 64},
}
BENCH = {
    "jitter and lost ticks": {"controller.jitter_s": 20e-6, "controller.lost_ticks": 0.05},
    "opened": NOTCH | {"controller.open_until_s": 0.2},
    "delay": {"controller.delay_s": 350e-6},
    "pulses": {"plate.pulse_ticks": 4000},
    "steps": STEPS | NOTCH,
    "rigid": {"finger.kind": "rigid"},
}


def runs() -> Iterator[tuple[str, fl.System, float]]:
    """Name, system and duration in s of each run."""
    for name, changes in PAPER.items():
        yield f"paper, {name}", fl.paper().evolve(changes), 2.0
    yield "feasible", fl.feasible(), 2.0
    bench = fl.bench()
    for law in LAWS:
        for length_um in LENGTHS_UM:
            yield (
                f"{law} at {length_um:g} um",
                bench.evolve({"controller.kind": law, "finger.slip_length_um": length_um} | GAINS.get(law, {})),
                2.0,
            )
    for name, changes in BENCH.items():
        yield f"bench, {name}", bench.evolve(changes), 2.0


def sweeps() -> Iterator[tuple[str, fl.System, Any, int]]:
    """Name, system, points and seeds of each sweep."""
    gains = {"controller.kp": np.linspace(0.5, 20.0, 5), "controller.ki": np.linspace(100.0, 4000.0, 5)}
    yield "grid", fl.paper(), gains, 2
    fingers = list(fl.fingers(40, 11))
    for law in ("notch_pi", "limit_observer"):
        yield (
            f"fingers under {law}",
            fl.bench().evolve(STEPS | {"controller.kind": law} | GAINS.get(law, {})),
            fingers,
            1,
        )


def digest(values: np.ndarray) -> str:
    """Sixteen hexadecimal digits that say the bits of an array."""
    return hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest()[:16]


def told(values: np.ndarray) -> dict[str, Any]:
    """Bits of an array, and its rms for those who ask how far off it is."""
    return {"bits": digest(values), "rms": float(np.sqrt(np.nanmean(np.square(values))))}


def measure() -> dict[str, dict[str, Any]]:
    """Digest of every run's force and command, and of every sweep's metrics."""
    found: dict[str, dict[str, Any]] = {}
    for name, system, duration_s in runs():
        run = fl.simulate(system, duration_s, seed=3)
        found[name] = {trace: told(run[trace].values) for trace in ("f_a", "f_m", "u", "a")}
    for name, system, points, seeds in sweeps():
        steps, still = system.setpoint.kind == "steps", system.motion.kind == "sliding"
        unfit = {"rise", "fall"} if not steps else set()
        unfit |= {"perceptual"} if still else {"r2_bound"}
        metrics = [metric for metric in fl.METRICS if not metric.startswith(tuple(unfit))]
        swept = fl.sweep(system, points, 2.0, seeds, metrics, score_from_s=0.2)
        found[name] = {metric: told(swept[metric].values) for metric in metrics}
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", type=Path, help="file that an earlier run of this command printed")
    options = parser.parse_args()
    found = measure()
    if options.against is None:
        print(json.dumps(found, indent=1))
        return 0
    before, differ = json.loads(options.against.read_text()), 0
    for name in before.keys() | found.keys():
        was, now = before.get(name, {}), found.get(name, {})
        for each in was.keys() | now.keys():
            if was.get(each) != now.get(each):
                differ += 1
                print(f"{name}: {each}: {was.get(each)} is now {now.get(each)}")
    print(
        f"{differ} differ of {len(before)} runs and sweeps" if differ else f"same bits: {len(before)} runs and sweeps"
    )
    return int(differ > 0)


if __name__ == "__main__":
    sys.exit(main())
