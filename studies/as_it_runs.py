"""What a limit observer leaves beside other laws, and its margins with what it has learnt at any time of a run.

``python -m studies.as_it_runs 100 12`` takes the first 100 capable fingers of the comparison, each with the resonance
as the bench's, and writes *results/as-it-runs.csv*. Ms is the worst of forces from 0.3 to 0.9 N, dry and as moist as at
the end, of the first 12 fingers; of the limit observer, of those 12 with the largest loop gain at any of `TIMES_S`.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from frictionloop.analysis.linear import linearise
from frictionloop.control.laws import law_of
from frictionloop.control.limit_observer import LimitState
from frictionloop.design.comparison import protocol
from frictionloop.design.comparison.entrants import ENTRANTS
from frictionloop.design.limit_synthesis import knowing
from frictionloop.design.plants import detuned
from frictionloop.loop.kernel.lowering import lower
from frictionloop.loop.kernel.slab import LANES, law_rows
from frictionloop.loop.simulate import run_tile
from frictionloop.loop.sweep import sweep
from frictionloop.loop.timing import periods_in
from frictionloop.parameters import FingerFriction, System, bench
from frictionloop.quantities import FrictionloopError
from studies.conditions import conditions, limit_observer
from studies.kept import both, keep

TIMES_S = (0.5, 1.0, 2.0, 4.0, 7.0, 11.0)
FORCES_N = (0.3, 0.6, 0.9)
SHIFTS = (0.0, -0.05, 0.05)
SEED = 5


def residual_n(system: System, people: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Return each finger's rms of the error over the three sines."""
    points = [{**each, "setpoint": protocol.setpoint_of(task)} for task in protocol.SINES for each in people]
    kept = {"score_from_s": protocol.START_S, "progress": False}
    found = sweep(system, points, protocol.DURATION_S, [SEED], ["rms_error"], **kept)  # type: ignore[arg-type]
    return np.sqrt(np.mean(found["rms_error"].values.reshape(len(protocol.SINES), -1) ** 2, axis=0))


def falls(system: System, people: Sequence[Mapping[str, Any]], duration_s: float) -> np.ndarray:
    """Return tau / ln 2 as each finger's law believes it at the end of a run."""
    place, found = LimitState._fields.index("fall"), []
    for start in range(0, len(people), LANES):
        systems = [system.evolve(dict(each)) for each in people[start : start + LANES]]
        tile = lower(systems, [SEED] * len(systems))
        run_tile(tile, periods_in(systems[0], duration_s))
        state_rows, *_ = law_rows(law_of(systems[0].controller))
        found += np.asarray(tile.slab.view(state_rows))[place, : len(systems)].tolist()
    return np.array(found)


def gains_as_run(system: System, people: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Return the largest tau over the believed one that a finger meets at `TIMES_S` of the sines."""
    worst, friction = np.zeros(len(people)), system.friction
    assert isinstance(friction, FingerFriction)
    for task in protocol.SINES:
        for time_s in TIMES_S:
            believed = math.log(2.0) * falls(system.evolve({"setpoint": protocol.setpoint_of(task)}), people, time_s)
            moist = -math.expm1(-time_s / friction.occlusion_s)
            true = [
                each["friction.susceptibility_per_um2"] * (1.0 - each["friction.moist_loss"] * moist) for each in people
            ]
            worst = np.maximum(worst, np.array(true) / believed)
    return worst


def peaks(system: System, finger: Mapping[str, Any], gain: float | None) -> list[float]:
    """Return the worst Ms of a finger over forces by `SHIFTS`; ``gain`` is what a limit observer has learnt."""
    there = system.evolve(dict(finger))
    worst = np.zeros(len(SHIFTS))
    for force in FORCES_N:
        for occluded in (0.0,) if gain else (0.0, -math.expm1(-protocol.DURATION_S / 20.0)):
            try:
                loop = linearise(knowing(there, gain) if gain else there, force_n=force, occluded=occluded)
                found = [(detuned(loop, 1.0 + off) if off else loop).sensitivity_peak() for off in SHIFTS]
            except FrictionloopError:  # out of this finger's reach
                continue
            worst = np.maximum(worst, found)
    return worst.tolist()


def rows(count: int, margins: int) -> Iterator[list[Any]]:
    """Yield the rows of the table: residuals of so many fingers, margins of the first or, as run, the worst of them."""
    told = {"observer": ENTRANTS["observer"](bench()), "notch_pi": ENTRANTS["notch_pi"](bench())}
    for strokes in conditions(count * 4):
        contact = strokes.system.finger.contact  # type: ignore[union-attr]
        people = strokes.people[:count]
        for name, law in {"limit_observer": limit_observer(contact), **told}.items():
            system = strokes.system.evolve(dict(law))
            left = 1e3 * residual_n(system, people)
            own: list[float | None] = [None] * margins
            looked = list(range(min(margins, len(people))))
            if name == "limit_observer":
                gains = gains_as_run(system, people)
                looked = np.argsort(-gains)[:margins].tolist()
                own = [float(gains[i]) for i in looked]
            worst = np.max([peaks(system, people[i], gain) for i, gain in zip(looked, own, strict=False)], axis=0)
            learnt = f"{own[0]:.2f}" if own[0] else ""
            line = [strokes.name, name, len(people), both(left), f"{left.max():.1f}", learnt]
            yield [*line, f"{worst[0]:.2f}", f"{worst[1:].max():.2f}"]


def main(count: int = 100, margins: int = 24) -> None:
    """Write the table."""
    heads = ["mm/s, contact", "law", "fingers", "rms, mN", "worst", "largest loop gain", "largest Ms", "5 % off"]
    keep("as-it-runs", f"as_it_runs {count} {margins}", heads, rows(count, margins))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
