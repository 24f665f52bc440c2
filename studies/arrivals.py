"""How much of twelve effects arrives under three laws, on 96 fingers that none of them was tuned on: three minutes.

``python -m studies.arrivals`` goes on where it was stopped, and writes what the report shows into the package
(``src/frictionloop/report/stored``).
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import frictionloop
from frictionloop.design.comparison import EVALUATION_SEED
from frictionloop.design.comparison.effect_comparison import Cell, Key, compare_effects
from frictionloop.parameters import bench
from frictionloop.quantities.code_version import package_version
from frictionloop.report import effect_arrivals as shown

RUNS = Path(__file__).parent / "runs" / "arrivals.json"
KEPT = Path(shown.__file__).parent / "stored" / shown.FILE
FINGERS = 96


def run(laws: Sequence[str], path: Path = RUNS, count: int = FINGERS, effects: Sequence[str] = shown.EFFECTS) -> Any:
    """Run what is not kept in ``path`` yet, keep it there cell by cell, and return all of it as it is stored."""
    about = {"command": shown.COMMAND, "version": package_version(), "seed": EVALUATION_SEED, "fingers": count}
    there = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    cells: dict[Key, Cell] = {}
    decided_by = about | {"code": _code()}
    if there.get("about") == decided_by:
        cells = {(law, effect, speed): cell for law, effect, speed, cell in there["cells"]}

    def save() -> None:
        rows = [[*key, cell] for key, cell in cells.items()]
        path.parent.mkdir(exist_ok=True)
        path.write_text(json.dumps({"about": decided_by, "cells": rows}), encoding="utf-8")

    compare_effects(bench(), effects, laws, count, EVALUATION_SEED, shown.SPEEDS_MM_S, kept=cells, save=save)
    found: dict[str, Any] = about | {"speeds_mm_s": shown.SPEEDS_MM_S, "laws": {}}
    for law in laws:
        ways = {name: [cells[law, name, speed] for speed in shown.SPEEDS_MM_S] for name in effects}
        found["laws"][law] = {
            name: {of: [float(f"{cell[of]:.4g}") for cell in over] for of in over[0]} for name, over in ways.items()
        }
    return found


def _code() -> str:
    """Return a digest of the package: what other code has run is not kept."""
    files = sorted(Path(frictionloop.__file__).parent.rglob("*.py"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:16]


if __name__ == "__main__":
    text = json.dumps(run(list(shown.LAWS)), indent=1)
    KEPT.write_text(re.sub(r"\[[^][]*\]", lambda row: " ".join(row[0].split()), text) + "\n", encoding="utf-8")
