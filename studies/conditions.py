"""Where laws are compared: each speed and slip length, with the capable ones of the comparison's fingers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from frictionloop.design.comparison import protocol
from frictionloop.parameters import System, bench
from frictionloop.physics.fingers import Fingers, fingers

LENGTHS_UM = protocol.lengths_of(bench())
BELIEFS = "spring_noise", "model.resonance_hz", "model.resonance_q", "model.sensor_hz", "susceptibility_spread"
LEARNING, MEASURED = (0.5587, 132.6, 13.69, 553.0, 3.0), (0.4438, 132.6, 13.12, 634.2, 1.05)


def limit_observer(length_um: float, measured: bool = False) -> dict[str, Any]:
    """Return a limit observer of the bench that is told its contact, and its tau if that is measured.

    As ``design_controller(bench(), "limit_observer", Wanted(sensitivity_peak=2.0))`` finds it, for a spread of 1.05 if
    tau is measured.
    """
    believed = zip(BELIEFS, MEASURED if measured else LEARNING, strict=True)
    return {
        "controller.kind": "limit_observer",
        "controller.compliance_um_per_n": length_um / 0.6,
        **{f"controller.{name}": value for name, value in believed},
    }


def told_tau(people: Fingers) -> Fingers:
    """Return fingers whose susceptibility, dry, is what the controller believes."""
    path = "friction.susceptibility_per_um2"
    return Fingers(each | {f"controller.model.{path.partition('.')[2]}": each[path]} for each in people)


class Strokes(NamedTuple):
    """One speed and slip length."""

    name: str
    system: System
    people: Fingers
    """Those that can be given 0.3 and 0.9 N at their mean load."""


def conditions(
    count: int = 1000, seed: int = protocol.EVALUATION_SEED, speeds: Sequence[float] = protocol.SPEEDS_MM_S
) -> Iterator[Strokes]:
    """Yield every speed, those of the comparison if no others are given, and slip length."""
    people = protocol.without_lengths(fingers(count, seed))
    for speed in speeds:
        for z in LENGTHS_UM:
            moving = {"motion.speed_mm_s": speed, "finger.slip_length_um": z, "motion.stroke_mm": protocol.STROKE_MM}
            own = bench().evolve(moving)
            able = Fingers(people[i] for i in protocol.able(own, people, speed).nonzero()[0])
            yield Strokes(f"{speed:g} mm/s, {z:g} um", own, able)
