"""What it is worth to measure a finger before the loop closes on it.

``python -m studies.gain_spread 1000`` takes every capable one of so many fingers of the comparison, at 20 and 80 mm/s.
A controller believes the bench's finger; or the finger's own friction and susceptibility by two plain strokes, as a
session does before its first trial, and then as it may be later: off by a factor up to 1.5 either way. Each law is
designed for the loop gain that is left, and is scored on three sines and three holds.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from frictionloop.design.comparison import trial_protocol
from frictionloop.design.controller_synthesis import synthesised
from frictionloop.design.requirements import Requirements
from frictionloop.experiments.measured_finger import simulated_finger
from frictionloop.parameters import System, bench
from studies.as_it_runs import residual_n
from studies.conditions import conditions
from studies.kept import both, keep

LAWS = ("notch_pi", "limit_observer")
LATER = 1.5
"""Factor up to which friction and susceptibility have changed since they were measured (assumed)."""
RANGE_N = 2.5
"""Of the bench's sensor, above which no friction is believed."""
BELIEVED = "controller.model.nominal_n", "controller.model.susceptibility_per_um2"


def told(system: System, people: Sequence[Mapping[str, Any]], spread: float, seed: int = 0) -> list[dict[str, Any]]:
    """Return fingers with what two plain strokes tell the controller of each, off by up to a factor either way."""
    off = spread ** np.random.default_rng(seed).uniform(-1.0, 1.0, (len(people), 2))
    found = []
    for finger, factors in zip(people, off.tolist(), strict=True):
        measured = simulated_finger(system.evolve(dict(finger)))
        values = min(measured.reach.high_n * factors[0], RANGE_N), measured.susceptibility_per_um2 * factors[1]
        found.append({**finger, **dict(zip(BELIEVED, values, strict=True))})
    return found


def rows(count: int) -> Iterator[list[Any]]:
    """Yield a row for each speed, law and knowledge of the finger."""
    known = {"nobody measured it": (2.7, None), "measured, and changed since": (LATER, LATER)}
    known["two plain strokes before"] = (1.1, 1.0)
    laws = {
        (law, gain): synthesised(bench(), law, Requirements(finger_gain=gain))[0].overrides
        for law in LAWS
        for gain, _ in known.values()
    }
    for there in conditions(count, speeds=(20.0, 80.0)):
        if there.system.finger.slip_length_um == 0.0:  # type: ignore[union-attr]
            continue
        for law in LAWS:
            for name, (gain, spread) in known.items():
                people = there.people if spread is None else told(there.system, there.people, spread)
                system = there.system.evolve(dict(laws[law, gain]))
                errors = (
                    1e3 * residual_n(system, people, each) for each in (trial_protocol.SINES, trial_protocol.HOLDS)
                )
                yield [there.name, law, name, f"{gain:g}", len(people), *map(both, errors)]


def main(count: int = 1000) -> None:
    """Write the table."""
    heads = ["mm/s, um", "law", "the finger", "gain up to", "fingers", "sines, mN", "holds, mN"]
    keep("gain-spread", f"gain_spread {count}", heads, rows(count))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
