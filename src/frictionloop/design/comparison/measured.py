"""What a law is told of its own device before it competes: the resonance, as the sensor's own ringing shows it.

Of the three devices that fingers meet, one has the bench's resonance and two are 5 % off. A law that bears a resonance
nobody has measured believes the bench's. A tracker is to be told what is there (docs/controllers.md), by a ring-down at
start-up (`identification.fit_ring_down`, which is off by 0.01 %).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from frictionloop.parameters import SuspendedSensor, System
from frictionloop.physics.fingers import Fingers

TOLD = ("tracker",)
"""Kinds of controllers that are told."""
ERROR = 0.002
"""Relative error of what they are told, too high and too low in turn (assumed: a warm day, a finger that weighs)."""
BELIEVED_HZ = "controller.model.resonance_hz"


def told(system: System, people: Fingers, law: Mapping[str, Any] | None) -> Fingers:
    """Return fingers with what a law believes of the resonance of each one's device; as they are for one not told.

    A law is overrides of the bench, None for none.
    """
    sensor = system.sensor
    if law is None or law.get("controller.kind") not in TOLD or not isinstance(sensor, SuspendedSensor):
        return people
    met = [float(each.get("sensor.resonance_hz", sensor.resonance_hz)) for each in people]
    found = [hz * (1.0 + (ERROR if i % 2 else -ERROR)) for i, hz in enumerate(met)]
    return Fingers(each | {BELIEVED_HZ: hz} for each, hz in zip(people, found, strict=True))


def on_device(system: System, factor: float) -> System:
    """Return a system whose sensor has its resonance times a factor, known to a controller that is told.

    A sensor without one is as it was.
    """
    if not isinstance(system.sensor, SuspendedSensor):
        return system
    there_hz = factor * system.sensor.resonance_hz
    known = {BELIEVED_HZ: there_hz} if system.controller.kind in TOLD else {}
    return system.evolve({"sensor.resonance_hz": there_hz, **known})
