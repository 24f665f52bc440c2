"""Where laws are compared: each speed and slip length, with the capable ones of the comparison's fingers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from frictionloop.design.comparison import trial_protocol
from frictionloop.parameters import System, bench
from frictionloop.physics.fingers import Fingers, fingers

LENGTHS_UM = trial_protocol.lengths_of(bench())

LIMIT_OBSERVER = {
    "controller.kind": "limit_observer",
    "controller.spring_noise": 0.6411,
    "controller.model.resonance_hz": 132.5,
    "controller.model.resonance_q": 10.17,
    "controller.model.sensor_hz": 868.0,
}
"""Of the bench, as ``design_controller(bench(), "limit_observer")`` finds it."""


class Strokes(NamedTuple):
    """One speed and slip length."""

    name: str
    system: System
    people: Fingers
    """Those that can be given 0.3 and 0.9 N at their mean load."""


def conditions(
    count: int = 1000,
    seed: int = trial_protocol.EVALUATION_SEED,
    speeds: Sequence[float] = trial_protocol.SPEEDS_MM_S,
) -> Iterator[Strokes]:
    """Yield every speed, those of the comparison if no others are given, and slip length."""
    people = trial_protocol.without_lengths(fingers(count, seed))
    for speed in speeds:
        for z in LENGTHS_UM:
            moving = {
                "motion.speed_mm_s": speed,
                "finger.slip_length_um": z,
                "motion.stroke_mm": trial_protocol.stroke_mm(speed),
            }
            own = bench().evolve(moving)
            able = Fingers(people[i] for i in trial_protocol.able(own, people, speed).nonzero()[0])
            yield Strokes(f"{speed:g} mm/s, {z:g} um", own, able)
