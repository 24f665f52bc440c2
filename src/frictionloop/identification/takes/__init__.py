"""Entries of a project beyond the force sensor: each kind from its recordings to measured values and drawings."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from frictionloop.identification.takes.finger import amplitude
from frictionloop.identification.takes.plate import carrier, delay, plate, scale
from frictionloop.identification.takes.touch import load, position

TAKES: dict[str, Callable[..., Any]] = {
    "load": load,
    "position": position,
    "scale": scale,
    "plate": plate,
    "carrier": carrier,
    "delay": delay,
    "amplitude": amplitude,
}
"""By kind: ``(take, runs, sensor, date) -> measured, sentences, table, what is drawn``."""
