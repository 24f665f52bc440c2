"""The values of a law beside those that every controller has, and how they are shown."""

from __future__ import annotations

from typing import Any

from frictionloop.findings.shown import shown
from frictionloop.parameters.system import System
from frictionloop.parameters.timing import Timing
from frictionloop.quantities import unit_of


def own_values(system: System) -> dict[str, Any]:
    """Return the values of a law beside those that every controller has."""
    return {name: value for name, value in system.controller if name not in {*Timing.model_fields, "kind"}}


def gains_said(system: System) -> str:
    """Return the values of a law for a person: kp 7.26   ki 64.7 1/s   notch 132 Hz."""
    told = []
    for name, value in own_values(system).items():
        if isinstance(value, (list, tuple)):
            told.append(f"{len(value)} {name}")
        elif value is not False:
            said, unit = "" if value is True else shown(value, 4), unit_of(name).replace("N/N", "")
            told.append(" ".join(filter(None, (name.removesuffix("_hz").replace("_", " "), said, unit))))
    return "   ".join(told)
