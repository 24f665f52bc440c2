"""What a tracker leaves on the comparison's fingers that nobody tells the resonance of its device: five minutes.

``python -m studies.untold`` takes what ``frictionloop design controller --law tracker`` finds (it bears 10 %)
and prints the table of *pages/laws.md*, "A default that bears every device".
"""

from __future__ import annotations

import numpy as np

import frictionloop as fl
from frictionloop.design.comparison import protocol
from frictionloop.design.comparison.scores import spread
from frictionloop.design.synthesis import design_controller
from frictionloop.physics.fingers import Fingers

COUNT, SEED = 1000, protocol.EVALUATION_SEED
KINDS = {"sines": protocol.SINES, "hold": protocol.HOLDS}


def main() -> None:
    """Print median and worst decile of the capable fingers for each speed, contact and kind of task, mN."""
    bench = fl.bench()
    untold = bench.evolve(design_controller(bench, "tracker").overrides)
    people = protocol.population(bench, COUNT, SEED)
    for speed in protocol.SPEEDS_MM_S:
        able = Fingers(people[i] for i in protocol.able(bench, people, speed).nonzero()[0])
        for contact in protocol.CONTACTS:
            for kind, tasks in KINDS.items():
                squares = []
                for task in tasks:
                    system = untold.evolve(protocol.overrides_of(protocol.Condition(speed, contact, task)))
                    seeds = [protocol.noise_seed(SEED, task)]
                    run = fl.sweep(
                        system, able, protocol.DURATION_S, seeds, ["rms_error"], score_from_s=protocol.START_S
                    )
                    squares.append(run["rms_error"].values.ravel() ** 2)
                middle, worst = spread(1e3 * np.sqrt(np.mean(squares, axis=0)), False)
                print(f"{speed:g} mm/s, {contact}, {kind}: {middle:.2f} / {worst:.2f} mN of {len(able)}", flush=True)


if __name__ == "__main__":
    main()
