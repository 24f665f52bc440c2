"""What a law does to the force after a turn, with feedback through it and without.

``python -m studies.turns 1000`` takes every capable one of so many fingers, a hold of 0.6 N in strokes of 3 s, and
keeps the force after a turn, the error with turns and without, and the share of sliding with feedback. *Through the
turn* is ``touch.load.developed_mm = 0``. At 5 and 10 mm/s all fingers count.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np

from frictionloop.design.comparison import trial_protocol
from frictionloop.design.controller_synthesis import synthesised
from frictionloop.design.requirements import Requirements
from frictionloop.loop.sweep import sweep
from frictionloop.parameters import RETUNED, Constant, bench
from frictionloop.physics.fingers import Fingers, fingers
from studies.kept import both, keep

LEVEL_N, DURATION_S, SEED = 0.6, 11.0, 5
SPEEDS_MM_S = (5.0, 10.0, 20.0, 40.0, 80.0, 150.0)
SLOW_MM_S = 10.0
"""Speed up to which nobody asks for the protocol's forces, and every finger counts."""
WAYS: dict[str, dict[str, float]] = {"through the turn": {"touch.load.developed_mm": 0.0}, "not until stretched": {}}
METRICS = ["turn_peak", "rms_error", "rms_error_turns", "feedback_share"]


def rows(count: int) -> Iterator[list[Any]]:
    """Yield a row for each speed, law and way of feedback."""
    people = fingers(count, trial_protocol.EVALUATION_SEED)
    laws = {"pi": {"controller.kind": "pi", **RETUNED}}
    laws |= {
        law: dict(synthesised(bench(), law, Requirements())[0].overrides) for law in ("notch_pi", "limit_observer")
    }
    for speed in SPEEDS_MM_S:
        stroke_mm = max(trial_protocol.stroke_mm(speed), 20.0)
        there = bench().evolve({"motion.speed_mm_s": speed, "motion.stroke_mm": stroke_mm})
        able = np.ones(count, bool) if speed <= SLOW_MM_S else trial_protocol.able(there, people, speed)
        some = Fingers(people[i] for i in able.nonzero()[0])
        for law, overrides in laws.items():
            for name, way in WAYS.items():
                system = there.evolve({**overrides, **way, "setpoint": Constant(offset_n=LEVEL_N)})
                found = sweep(system, some, DURATION_S, [SEED], METRICS, score_from_s=1.0, progress=False)
                peak, error, whole, share = (found[each].values.ravel() for each in METRICS)
                yield [
                    f"{speed:g}", law, name, len(some), both(peak, 2), both(1e3 * error), both(1e3 * whole),
                    f"{np.median(share):.1%}",
                ]  # fmt: skip


def main(count: int = 1000) -> None:
    """Write the table."""
    heads = ["mm/s", "law", "feedback", "fingers", "peak, N", "rms, mN", "with turns, mN", "share"]
    keep("turns", f"turns {count}", heads, rows(count))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
