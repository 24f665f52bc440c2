"""What a limit observer leaves beside `notch_pi`, and the margins of both on the fingers with the highest loop gain.

``python -m studies.as_it_runs 1000 20`` takes every capable one of 1000 fingers of the comparison, each with the
resonance as the bench's, and writes *results/as-it-runs.csv*. Ms is the worst of forces from 0.3 to 0.9 N, dry and
moist, on the 20 of the largest loop gain, with the resonance as described and 10 % off either way.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from frictionloop.analysis.linear import linearise
from frictionloop.design.comparison import trial_protocol
from frictionloop.design.comparison.trial_protocol import designed
from frictionloop.design.plant_set import detuned
from frictionloop.design.population_margins import loop_gain
from frictionloop.design.requirements import Requirements
from frictionloop.loop.sweep import sweep
from frictionloop.parameters import System, bench
from frictionloop.quantities import FrictionloopError
from studies.conditions import LIMIT_OBSERVER, conditions
from studies.kept import both, keep

SPEEDS_MM_S = (20.0, 80.0, 150.0)
FORCES_N = (0.3, 0.6, 0.9)
SHIFTS = (0.0, -0.1, 0.1)
SEED = 5


def residual_n(system: System, people: Sequence[Mapping[str, Any]], tasks: Sequence[str]) -> np.ndarray:
    """Return each finger's rms of the error over some tasks."""
    points = [{**each, "setpoint": trial_protocol.setpoint_of(task)} for task in tasks for each in people]
    kept = {"score_from_s": trial_protocol.START_S, "progress": False}
    found = sweep(system, points, trial_protocol.DURATION_S, [SEED], ["rms_error"], **kept)  # type: ignore[arg-type]
    return np.sqrt(np.mean(found["rms_error"].values.reshape(len(tasks), -1) ** 2, axis=0))


def peaks(system: System, finger: Mapping[str, Any]) -> np.ndarray:
    """Return the worst Ms of a finger, by `SHIFTS`."""
    found, there = [np.ones(len(SHIFTS))], system.evolve(dict(finger))
    for force in FORCES_N:
        for occluded in (0.0, -math.expm1(-trial_protocol.DURATION_S / 20.0)):
            with suppress(FrictionloopError):  # out of reach
                loop = linearise(there, force_n=force, occluded=occluded)
                moved = [replace(detuned(loop, 1.0 + off), known_law=loop.law) for off in SHIFTS]
                found.append(np.array([each.sensitivity_peak() for each in moved]))
    return np.max(found, axis=0)


def main(count: int = 1000, margins: int = 20) -> None:
    """Write the table."""
    notch_pi = designed("notch_pi", Requirements(slip_lengths_um=()))
    laws = {"limit_observer": LIMIT_OBSERVER, "notch_pi": notch_pi(bench())}

    def rows() -> Iterator[Any]:
        for there in conditions(count, speeds=SPEEDS_MM_S):
            for name, law in laws.items():
                system = there.system.evolve(dict(law))
                gains = [-np.nan_to_num(loop_gain(system.evolve(dict(each)))) for each in there.people]
                most = [there.people[k] for k in np.argsort(gains)[:margins]]
                sines, holds = (
                    1e3 * residual_n(system, there.people, each)
                    for each in (trial_protocol.SINES, trial_protocol.HOLDS)
                )
                ms = np.array([peaks(system, each) for each in most])
                largest = ms.max(axis=0)
                yield [
                    there.name, name, len(there.people), both(sines), both(holds),
                    f"{-min(gains):.2f}",
                    f"{largest[0]:.2f}", f"{largest[1:].max():.2f}",
                ]  # fmt: skip

    heads = ["mm/s, um", "law", "fingers", "sines, mN", "holds, mN", "largest loop gain", "largest Ms", "10 % off"]
    keep("as-it-runs", f"as_it_runs {count} {margins}", heads, rows())


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
