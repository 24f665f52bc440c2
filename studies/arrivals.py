"""How much of twelve effects arrives under four laws, on 96 fingers that none of them was tuned on: ten minutes.

``python -m studies.arrivals`` goes on where it was stopped, and writes what the report shows into the package
(``src/frictionloop/report/stored``). ``python -m studies.arrivals tracker`` adds another entrant of the comparison.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from frictionloop.design.comparison import EVALUATION_SEED, protocol
from frictionloop.design.comparison.entrants import ENTRANTS, told
from frictionloop.loop.progress import progress_bar
from frictionloop.parameters import System, bench
from frictionloop.preview.asked import check
from frictionloop.preview.effect import prepared
from frictionloop.preview.people import delivered_to, spread_n
from frictionloop.quantities.version import package_version
from frictionloop.report import arrivals as shown

RUNS = Path(__file__).parent / "runs" / "arrivals.json"
KEPT = Path(shown.__file__).parent / "stored" / shown.FILE
FINGERS = 96
SEED = 0
"""Seed of the noise; that of the fingers is the comparison's."""


def arrived(system: System, name: str, law: Mapping[str, Any], speed_mm_s: float, count: int) -> dict[str, float]:
    """Return what is told of an effect under a law at a speed: of the capable of so many fingers, but ``spread_all``.

    A worst decile is the least contrast, or the largest error, that nine of ten fingers are given.
    """
    people = protocol.population(system, count, EVALUATION_SEED)
    able = protocol.able(system, people, speed_mm_s)
    systems = [prepared(name, system.evolve(each).evolve(law), speed_mm_s) for each in told(system, people, law)]
    check(systems[0])
    ways = delivered_to(systems, SEED)
    some = [way for way, counts in zip(ways, able, strict=True) if counts]
    found = {"spread_n": spread_n(some), "spread_all_n": spread_n(ways)}
    for of, worst in (("contrast", 0.1), ("rms_error_n", 0.9), ("error_felt", 0.9), ("pattern_felt", 0.1)):
        values = np.array([getattr(way, of) for way in some])
        found |= {of: float(np.median(values)), f"{of}_worst": float(np.quantile(values, worst))}
    return found


def run(laws: Sequence[str], path: Path = RUNS, count: int = FINGERS, effects: Sequence[str] = shown.EFFECTS) -> Any:
    """Run what is not kept in ``path`` yet, keep it there cell by cell, and return all of it."""
    about = {"command": shown.COMMAND, "version": package_version(), "seed": EVALUATION_SEED, "fingers": count}
    kept = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    if {key: kept.get(key) for key in about} != about:
        people = protocol.population(bench(), count, EVALUATION_SEED)
        able = [int(protocol.able(bench(), people, speed).sum()) for speed in shown.SPEEDS_MM_S]
        kept = about | {"speeds_mm_s": shown.SPEEDS_MM_S, "capable": able, "laws": {}}
    path.parent.mkdir(exist_ok=True)
    with progress_bar("arrivals", len(laws) * len(effects)) as bar:
        for law in laws:
            overrides = ENTRANTS[law](bench())
            own = kept["laws"].setdefault(law, {})
            for name in effects:
                bar.doing(f"{name}, {law}")
                if name not in own:
                    cells = [arrived(bench(), name, overrides, speed, count) for speed in shown.SPEEDS_MM_S]
                    own[name] = {of: [float(f"{cell[of]:.4g}") for cell in cells] for of in cells[0]}
                    path.write_text(json.dumps(kept), encoding="utf-8")
                bar()
    return kept


if __name__ == "__main__":
    text = json.dumps(run([*shown.RUN, *sys.argv[1:]]), indent=1)
    KEPT.write_text(re.sub(r"\[[^][]*\]", lambda row: " ".join(row[0].split()), text) + "\n", encoding="utf-8")
