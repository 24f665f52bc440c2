"""What a tracker leaves on the comparison's fingers that nobody tells the resonance of its device: five minutes.

``python -m studies.untold`` takes what ``frictionloop design controller --law tracker`` finds (it bears 10 %)
and keeps what *pages/laws.md* shows of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

import frictionloop as fl
from frictionloop.design.comparison import protocol
from frictionloop.design.synthesis import design_controller
from frictionloop.physics.fingers import Fingers
from studies.kept import keep

COUNT, SEED = 1000, protocol.EVALUATION_SEED
KINDS = {"sines": protocol.SINES, "hold": protocol.HOLDS}


def main() -> None:
    """Keep the median of the capable fingers for each speed, contact and kind of task, mN."""
    keep("untold", "untold", ("mm/s", "contact", "fingers", *KINDS), rows())


def rows() -> Iterator[list[Any]]:
    """Yield what is kept of each speed and contact."""
    bench = fl.bench()
    untold = bench.evolve(design_controller(bench, "tracker").overrides)
    people = protocol.population(bench, COUNT, SEED)
    for speed in protocol.SPEEDS_MM_S:
        able = Fingers(people[i] for i in protocol.able(bench, people, speed).nonzero()[0])
        for contact in protocol.CONTACTS:
            cells = []
            for tasks in KINDS.values():
                squares = []
                for task in tasks:
                    system = untold.evolve(protocol.overrides_of(protocol.Condition(speed, contact, task)))
                    seeds = [protocol.noise_seed(SEED, task)]
                    run = fl.sweep(
                        system, able, protocol.DURATION_S, seeds, ["rms_error"], score_from_s=protocol.START_S
                    )
                    squares.append(run["rms_error"].values.ravel() ** 2)
                cells.append(f"{1e3 * np.median(np.sqrt(np.mean(squares, axis=0))):.1f}")
            yield [f"{speed:g}", contact, len(able), *cells]


if __name__ == "__main__":
    main()
