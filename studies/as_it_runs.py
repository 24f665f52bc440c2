"""What a limit observer leaves beside other laws, and its margins with what it has learnt at any time of a run.

``python -m studies.as_it_runs 300 1`` takes every capable one of 300 fingers of the comparison, each with the
resonance as the bench's, and writes *results/as-it-runs.csv* and the worst of all in *as-it-runs-worst.csv*. Ms is the
worst of forces from 0.3 to 0.9 N; of the limit observer, of every finger, with the largest loop gain at any of
`TIMES_S`; of other laws, of the first, dry and as moist as at the end. ``300 0`` is for one that is told each finger's
tau, into *as-it-runs-measured.csv*.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from frictionloop.analysis.linear import LinearLoop, linearise
from frictionloop.control.laws import law_of
from frictionloop.control.limit_step import LimitState
from frictionloop.design.comparison import protocol
from frictionloop.design.comparison.entrants import ENTRANTS
from frictionloop.design.limit_linear import lag_of, small_signals
from frictionloop.design.plants import Plants, detuned
from frictionloop.loop.kernel.lowering import lower
from frictionloop.loop.kernel.slab import LANES, law_rows
from frictionloop.loop.simulate import run_tile
from frictionloop.loop.sweep import sweep
from frictionloop.loop.timing import periods_in
from frictionloop.parameters import FingerFriction, System, bench
from frictionloop.quantities import FrictionloopError
from studies.conditions import Strokes, conditions, limit_observer, told_tau
from studies.kept import both, keep

TIMES_S = (0.5, 1.0, 2.0, 4.0, 7.0, 11.0)
SPEEDS_MM_S = (20.0, 80.0, 150.0)
FORCES_N = (0.3, 0.6, 0.9)
SHIFTS = (0.0, -0.05, 0.05)
SEED = 5
MEASURED = "limit_observer, tau measured"


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


def loops(system: System, moistures: Sequence[float]) -> Iterator[LinearLoop]:
    """Yield loops at the forces that the plate can give this finger."""
    for force in FORCES_N:
        for occluded in moistures:
            with suppress(FrictionloopError):  # out of reach
                yield linearise(system, force_n=force, occluded=occluded)


def peaks(system: System, finger: Mapping[str, Any]) -> np.ndarray:
    """Return the worst Ms of a finger under a law that learns nothing, by `SHIFTS`."""
    found = []
    for loop in loops(system.evolve(dict(finger)), (0.0, -math.expm1(-protocol.DURATION_S / 20.0))):
        there = [replace(detuned(loop, 1.0 + off), known_law=loop.law) for off in SHIFTS]
        found.append([each.sensitivity_peak() for each in there])
    return np.max(found, axis=0)


def peaks_as_run(system: System, finger: Mapping[str, Any], gain: float) -> np.ndarray:
    """Return that of a limit observer at a loop gain, by the matrices of its design."""
    c: Any = system.controller
    dry = list(loops(system.evolve({**finger, "controller.kind": "pi"}), (0.0,)))
    plants = Plants.of([detuned(loop, 1.0 + off) if off else loop for loop in dry for off in SHIFTS], overdrive=True)
    laws = [
        small_signals(c.model, c.rate_hz, c.bandwidth_hz, c.spring_noise, lag_of(loop)).response(plants.frequency_hz)
        * (gain / loop.elements.plate.num[-1] * loop.elements.plate.den[-1])
        for loop in dry
    ]
    return plants.peaks(np.repeat(np.array(laws)[:, :, 0, 0], len(SHIFTS), axis=0)).reshape(-1, len(SHIFTS)).max(axis=0)


def rows(laws: Mapping[str, Any], strokes: Sequence[Strokes], margins: int, worst: list[list[Any]]) -> Iterator[Any]:
    """Yield the rows of the table; ``worst`` gets what each finger has under a limit observer."""
    for (name, law), there in product(laws.items(), strokes):
        people, learnt = told_tau(there.people) if name == MEASURED else there.people, ""
        own: Any = there.system
        system = own.evolve(dict(law(own.finger.slip_length_um) if callable(law) else law))
        left = 1e3 * residual_n(system, people)
        if callable(law):
            gains = gains_as_run(system, people)
            found = np.array([peaks_as_run(system, *each) for each in zip(people, gains, strict=True)])
            learnt = f"{gains.max():.2f}"
            worst += [
                [there.name, person["motion.person"], f"{gain:.2f}", f"{ms[0]:.2f}", f"{ms[1:].max():.2f}"]
                for person, gain, ms in zip(people, gains, found, strict=True)
            ]
        else:
            found = np.array([peaks(system, person) for person in people[:margins]])
        ms = f"{found[:, 0].max():.2f}", f"{found[:, 1:].max():.2f}"
        yield [there.name, name, len(people), both(left), f"{left.max():.1f}", learnt, *ms]


def main(count: int = 1000, margins: int = 4) -> None:
    """Write the tables; those of a tau that is measured without margins of others, where they are 0."""
    heads = ["mm/s, um", "law", "fingers", "rms, mN", "worst", "largest loop gain", "largest Ms", "5 % off"]
    strokes = list(conditions(count, speeds=SPEEDS_MM_S))
    worst: list[list[Any]] = []
    command = f"as_it_runs {count} {margins}"
    if margins == 0:
        law = {MEASURED: partial(limit_observer, measured=True)}
        keep("as-it-runs-measured", command, heads, rows(law, strokes, 0, worst))
        return
    laws = {"limit_observer": limit_observer} | {law: ENTRANTS[law](bench()) for law in ("observer", "notch_pi")}
    keep("as-it-runs", command, heads, rows(laws, strokes, margins, worst))
    worst.sort(key=lambda each: -float(each[3]))
    keep("as-it-runs-worst", command, ["mm/s, um", "finger", "loop gain", "Ms", "5 % off"], worst[:10])


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
